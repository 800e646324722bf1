//! The files of a sweep, which grow line by line: sweep.jsonl, from which an interrupted sweep goes on, and sweep.csv.
//!
//! A line is whole or not there. What a crash has torn is cut off when the sweep goes on, and sweep.csv is written anew from
//! sweep.jsonl then.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::row::{Row, csv_header};
use super::sweep::SweepTask;
use crate::error::{Error, Result};
use crate::output::write_atomically;
use crate::scene::Scene;

/// The first line of sweep.jsonl: what is swept over.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Header {
    /// Of the file: 1.
    pub format: u32,
    /// Of the program.
    pub version: String,
    /// The scene's file.
    pub scene: String,
    /// Of the scene's text, its files' lengths, and what is said on top of it.
    pub fingerprint: String,
    /// The keys that vary and their values.
    pub vary: Vec<(String, Vec<String>)>,
    /// Where it is asked to run.
    pub backend: String,
}

impl Header {
    /// The header of a task.
    ///
    /// # Errors
    /// [`Error::Read`] where a file of the scene is not there.
    pub(super) fn new(task: &SweepTask<'_>, scene: &Scene) -> Result<Self> {
        let unreadable = |path: &Path| {
            let path = path.to_owned();
            move |source| Error::Read { path, source }
        };
        let mut hash = Fnv::default();
        for path in scene.inputs() {
            let length = std::fs::metadata(path).map_err(unreadable(path))?.len();
            hash.add(&length.to_le_bytes());
        }
        if crate::scene::is_scene_file(task.path) {
            hash.add(&std::fs::read(task.path).map_err(unreadable(task.path))?);
        }
        hash.add(format!("{:?}", task.overrides).as_bytes());
        Ok(Self {
            format: 1,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: task.path.display().to_string(),
            fingerprint: format!("{:016x}", hash.0),
            vary: (task.vary.iter())
                .map(|v| (v.key.clone(), v.values.clone()))
                .collect(),
            backend: format!("{:?}", task.backend),
        })
    }
}

/// Fowler, Noll and Vo's hash 1a of 64 bits.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// The files of a sweep, open to grow.
pub(super) struct Journal {
    lines: Growing,
    csv: Growing,
    rows: Vec<Row>,
}

impl Journal {
    /// Opens the files of a folder, or begins them.
    ///
    /// # Errors
    /// [`Error::Setting`] where the folder holds another sweep or a damaged one, [`Error::Read`] and [`Error::Write`].
    pub(super) fn open(folder: &Path, header: &Header) -> Result<Self> {
        let path = folder.join("sweep.jsonl");
        let text = match std::fs::read(&path) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(source) => return Err(Error::Read { path, source }),
        };
        let refused = |problem: &str| {
            Error::Setting(format!(
                "{} {problem}; name another folder, or move it away",
                path.display()
            ))
        };
        // What follows the last line break was torn.
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let mut lines = whole.lines();
        let mut rows: Vec<Row> = Vec::new();
        if let Some(first) = lines.next() {
            match serde_json::from_str::<Header>(first) {
                Ok(found) if found == *header => {}
                Ok(_) => return Err(refused("is of another sweep, scene or version")),
                Err(_) => return Err(refused("is no journal of a sweep")),
            }
            for (index, line) in lines.enumerate() {
                match serde_json::from_str(line) {
                    Ok(row) => rows.push(row),
                    Err(_) => return Err(refused(&format!("is damaged in line {}", index + 2))),
                }
            }
        }
        let keys: Vec<String> = header.vary.iter().map(|(key, _)| key.clone()).collect();
        let csv_path = folder.join("sweep.csv");
        write_atomically(&csv_path, |file| {
            file.write_all(csv_header(&keys).as_bytes())?;
            rows.iter()
                .try_for_each(|row| file.write_all(row.csv().as_bytes()))
        })?;
        let mut lines = Growing::open(path, whole.len() as u64)?;
        if whole.is_empty() {
            lines.append(&line(header)?)?;
        }
        let length = std::fs::metadata(&csv_path).map(|m| m.len());
        let length = length.map_err(|source| Error::Read {
            path: csv_path.clone(),
            source,
        })?;
        Ok(Self {
            lines,
            csv: Growing::open(csv_path, length)?,
            rows,
        })
    }

    /// Whether a frame is there.
    pub(super) fn holds(&self, combination: usize, round: u32) -> bool {
        (self.rows.iter()).any(|r| r.combination == combination && r.round == round)
    }

    /// Adds a row to both files.
    ///
    /// # Errors
    /// [`Error::Write`]; the files end with whole lines then, too.
    pub(super) fn append(&mut self, row: Row) -> Result<()> {
        self.lines.append(&line(&row)?)?;
        self.csv.append(&row.csv())?;
        self.rows.push(row);
        Ok(())
    }

    /// All rows.
    pub(super) fn into_rows(self) -> Vec<Row> {
        self.rows
    }
}

fn line(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(value);
    Ok(text.map_err(|e| Error::Setting(format!("a row cannot be written: {e}")))? + "\n")
}

/// A file that grows by whole lines.
struct Growing {
    path: PathBuf,
    file: File,
    length: u64,
}

impl Growing {
    /// Opens a file and cuts off what lies behind `length`.
    fn open(path: PathBuf, length: u64) -> Result<Self> {
        let open = || {
            let file = OpenOptions::new().create(true).append(true).open(&path)?;
            file.set_len(length)?;
            Ok(file)
        };
        match open() {
            Ok(file) => Ok(Self { path, file, length }),
            Err(source) => Err(Error::Write { path, source }),
        }
    }

    fn append(&mut self, line: &str) -> Result<()> {
        if let Err(source) = self.file.write_all(line.as_bytes()) {
            // A full disk must not leave half a line.
            let _ = self.file.set_len(self.length);
            return Err(Error::Write {
                path: self.path.clone(),
                source,
            });
        }
        self.length += line.len() as u64;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Cost, Quality};
    use super::*;

    fn header() -> Header {
        Header {
            format: 1,
            version: "0".to_owned(),
            scene: "s.toml".to_owned(),
            fingerprint: "0".to_owned(),
            vary: vec![("a,b".to_owned(), vec!["1".to_owned()])],
            backend: "Cpu".to_owned(),
        }
    }

    fn row(round: u32) -> Row {
        let cost = Cost {
            wall_ms: 1.5,
            cpu_ms: None,
            peak_memory_bytes: None,
            passes: Vec::new(),
        };
        let mut row = Row::new(cost, 2.0, Quality::default(), None);
        row.round = round;
        row.values = vec!["say \"x\", y".to_owned()];
        row
    }

    #[test]
    fn what_was_torn_is_cut_off_and_run_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let open = || Journal::open(folder.path(), &header());
        let mut journal = open().expect("a new journal");
        journal.append(row(0)).expect("a row");
        journal.append(row(1)).expect("a row");
        drop(journal);
        let path = folder.path().join("sweep.jsonl");
        let text = std::fs::read_to_string(&path).expect("text");
        std::fs::write(&path, &text[..text.len() - 9]).expect("torn");
        std::fs::write(folder.path().join("sweep.csv"), "nonsense").expect("torn");
        let mut journal = open().expect("goes on");
        assert!(
            journal.holds(0, 0) && !journal.holds(0, 1),
            "the second row was torn"
        );
        journal.append(row(1)).expect("a row");
        assert_eq!(std::fs::read_to_string(&path).expect("text"), text);
        let csv = std::fs::read_to_string(folder.path().join("sweep.csv")).expect("text");
        assert!(
            csv.starts_with("combination,round,\"a,b\",wall_ms,") && csv.lines().count() == 3,
            "{csv}"
        );
        assert!(
            csv.contains("\n0,1,\"say \"\"x\"\", y\",1.5,,2,0.75,"),
            "{csv}"
        );
    }

    #[test]
    fn another_sweep_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        drop(Journal::open(folder.path(), &header()).expect("a new journal"));
        let other = Header {
            fingerprint: "1".to_owned(),
            ..header()
        };
        assert!(Journal::open(folder.path(), &other).is_err());
        let path = folder.path().join("sweep.jsonl");
        std::fs::write(&path, line(&header()).expect("a line") + "{}\n").expect("damaged");
        let said = Journal::open(folder.path(), &header())
            .err()
            .map(|e| e.to_string());
        assert!(said.is_some_and(|s| s.contains("line 2")));
    }
}
