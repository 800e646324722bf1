//! What has changed of a scene into the text of its file: the rest stays as it is written.

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike};

use super::Sections;

/// Brings `document`, which says what `old` has, to say what `new` has. Comments before what is removed go to the end of the
/// text: they may be about something else.
pub(super) fn into(document: &mut DocumentMut, old: Option<&Sections>, new: &Sections) {
    let mut orphans = String::new();
    for (index, (key, tables)) in new.lists.iter().enumerate() {
        let was = old.and_then(|old| old.lists.get(index));
        let was = was.map_or(&[][..], |(_, tables)| tables);
        list(document, key, was, tables, &mut orphans);
    }
    for (index, (key, table)) in new.tables.iter().enumerate() {
        let was = old.and_then(|old| old.tables.get(index));
        if table.is_empty() {
            if was.is_none_or(|(_, was)| !was.is_empty())
                && let Some(Item::Table(removed)) = document.remove(key)
            {
                keep_comments(&removed, &mut orphans);
            }
            continue;
        }
        let empty = Table::new();
        let there = document.entry(key).or_insert_with(|| {
            let mut there = Table::new();
            // No header of its own where only tables are in it.
            there.set_implicit(table.iter().all(|(_, item)| item.is_table()));
            Item::Table(there)
        });
        match there.as_table_like_mut() {
            Some(there) => update(there, was.map_or(&empty, |(_, was)| was), table),
            None => *there = Item::Table(table.clone()),
        }
    }
    if !orphans.is_empty() {
        let end = document.trailing().as_str().unwrap_or_default().to_owned();
        document.set_trailing(format!("{end}{orphans}"));
    }
}

/// Sets the keys that differ, and removes those that went.
fn update(there: &mut dyn TableLike, was: &Table, is: &Table) {
    let gone: Vec<String> = (was.iter())
        .filter(|(key, _)| !is.contains_key(key))
        .map(|(key, _)| key.to_owned())
        .collect();
    for key in gone {
        there.remove(&key);
    }
    for (key, item) in is {
        let before = was.get(key);
        if before.is_some_and(|before| text(before) == text(item)) && there.contains_key(key) {
            continue;
        }
        let tables = (item.as_table(), there.get_mut(key));
        if let (Some(table), Some(inner)) = tables
            && let Some(inner) = inner.as_table_like_mut()
        {
            let empty = Table::new();
            update(
                inner,
                before.and_then(Item::as_table).unwrap_or(&empty),
                table,
            );
            continue;
        }
        let mut item = item.clone();
        // A comment behind the old value stays behind the new one.
        let decor = there
            .get(key)
            .and_then(Item::as_value)
            .map(|v| v.decor().clone());
        if let (Some(decor), Some(value)) = (decor, item.as_value_mut()) {
            *value.decor_mut() = decor;
        }
        match there.get_mut(key) {
            Some(old) => *old = item,
            None => {
                there.insert(key, item);
            }
        }
    }
}

/// The entries of a list of tables: those that are as they were stay, wherever they are now.
fn list(document: &mut DocumentMut, key: &str, was: &[Table], is: &[Table], orphans: &mut String) {
    let texts = |tables: &[Table]| -> Vec<String> { tables.iter().map(Table::to_string).collect() };
    let (old_texts, new_texts) = (texts(was), texts(is));
    if old_texts == new_texts && document.contains_key(key) != is.is_empty() {
        return;
    }
    let there: Vec<Table> = match document.remove(key) {
        Some(Item::ArrayOfTables(list)) => list.into_iter().collect(),
        // Written in one line: it is spelt out.
        _ => Vec::new(),
    };
    let mut there: Vec<Option<Table>> = there.into_iter().map(Some).collect();
    let known = there.len() == was.len();
    let mut entries = ArrayOfTables::new();
    for (index, (table, text)) in is.iter().zip(&new_texts).enumerate() {
        let unused = |k: &usize| there.get(*k).is_some_and(Option::is_some);
        let same = (0..old_texts.len()).find(|k| unused(k) && old_texts.get(*k) == Some(text));
        let taken = |k: &usize| old_texts.get(*k).is_some_and(|old| new_texts.contains(old));
        // One that changed is the one at its place that is not found elsewhere.
        let changed = Some(index).filter(|k| unused(k) && !taken(k));
        let entry = match same.or(changed).filter(|_| known) {
            Some(k) => there.get_mut(k).and_then(Option::take).map(|mut entry| {
                if let Some(was) = was.get(k) {
                    update(&mut entry, was, table);
                }
                entry
            }),
            None => None,
        };
        entries.push(entry.unwrap_or_else(|| table.clone()));
    }
    for removed in there.iter().flatten() {
        keep_comments(removed, orphans);
    }
    if !entries.is_empty() {
        document.insert(key, Item::ArrayOfTables(entries));
    }
}

fn keep_comments(removed: &Table, orphans: &mut String) {
    let prefix = removed.decor().prefix().and_then(|prefix| prefix.as_str());
    let prefix = prefix.unwrap_or_default();
    if prefix.contains('#') {
        orphans.push_str(prefix);
    }
}

fn text(item: &Item) -> String {
    match item {
        Item::Table(table) => table.to_string(),
        Item::ArrayOfTables(list) => list.iter().map(Table::to_string).collect(),
        other => other.to_string(),
    }
}
