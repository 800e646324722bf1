//! The linker that puts `#import`s into shaders.

use crate::error::{Error, Result};

/// Puts the files of `shaders/shared` in the place of the `#import` lines that name them, each once.
///
/// # Errors
/// Where a name is not in `shared`.
pub fn link(source: &str, shared: &[(&str, &str)]) -> Result<String> {
    let mut linked = String::new();
    let mut seen = Vec::new();
    append(source, shared, &mut seen, &mut linked)?;
    Ok(linked)
}

fn append<'a>(
    source: &'a str,
    shared: &[(&str, &'a str)],
    seen: &mut Vec<&'a str>,
    linked: &mut String,
) -> Result<()> {
    for line in source.lines() {
        let Some(name) = line.strip_prefix("#import ").map(str::trim) else {
            linked.push_str(line);
            linked.push('\n');
            continue;
        };
        if seen.contains(&name) {
            continue;
        }
        seen.push(name);
        let Some((_, text)) = shared.iter().find(|(known, _)| *known == name) else {
            return Err(Error::Gpu(format!(
                "a shader imports {name:?}, which does not exist"
            )));
        };
        append(text, shared, seen, linked)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILES: &[(&str, &str)] = &[("a", "#import b\nA"), ("b", "#import a\nB")];

    #[test]
    fn an_import_is_replaced_once_even_in_a_cycle() {
        assert_eq!(
            link("#import a\n#import b\nC", FILES).expect("known names"),
            "B\nA\nC\n"
        );
    }

    #[test]
    fn an_unknown_import_is_refused_by_name() {
        let error = link("#import c", FILES)
            .expect_err("there is no c")
            .to_string();
        assert!(error.contains("\"c\""), "{error}");
    }
}
