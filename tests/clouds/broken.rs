//! Broken files: a sentence, or a cloud where the damage is harmless; never a panic, a wait or a huge allocation.

use std::time::{Duration, Instant};

use catoptric::cloud::RawCloud;
use catoptric::cloud::ReadOptions;
use catoptric::{Error, Result};
use libtest_mimic::{Failed, Trial};

use super::las_files::{las_bytes, points};
use super::ply_files::{ENCODINGS, Encoding, ply};
use super::{demand, read, read_bytes};

/// Longest that a small broken file may take.
const PATIENCE: Duration = Duration::from_secs(5);

pub(super) fn tests() -> Vec<Trial> {
    vec![
        Trial::test("a_truncated_ply_is_a_sentence", truncated_ply),
        Trial::test("a_truncated_las_or_laz_is_a_sentence", truncated_las),
        Trial::test("flipped_bits_never_panic", flipped_bits),
        Trial::test("a_ply_line_without_end_is_a_sentence", endless_line),
        Trial::test("what_a_ply_header_does_not_promise_is_refused", surplus),
        Trial::test("absurd_ply_headers_are_sentences", absurd_ply_headers),
        Trial::test("absurd_las_headers_are_sentences", absurd_las_headers),
        Trial::test("what_is_no_point_file_is_a_sentence", no_point_files),
        Trial::test("a_pipe_is_refused_without_waiting", pipe),
    ]
}

/// An outcome that a user can bear: a cloud, or one sentence.
fn demand_bearable(
    what: &str,
    started: Instant,
    outcome: &Result<RawCloud>,
) -> std::result::Result<(), Failed> {
    demand(
        started.elapsed() < PATIENCE,
        format!("{what} took {:?}", started.elapsed()),
    )?;
    let Err(error) = outcome else { return Ok(()) };
    let said = error.to_string();
    let sentence = !said.contains('\n') && !said.chars().any(char::is_control) && said.len() > 20;
    let kind = matches!(error, Error::Cloud { .. } | Error::Memory { .. });
    demand(sentence && kind, format!("{what} says {said:?}"))
}

fn demand_sentence(what: &str, bytes: &[u8]) -> std::result::Result<(), Failed> {
    let started = Instant::now();
    let outcome = read_bytes(bytes, &ReadOptions::default());
    demand_bearable(what, started, &outcome)?;
    demand(
        outcome.is_err(),
        format!("{what} was read as if it were whole"),
    )
}

fn demand_harmless(what: &str, bytes: &[u8]) -> std::result::Result<(), Failed> {
    let started = Instant::now();
    demand_bearable(what, started, &read_bytes(bytes, &ReadOptions::default()))
}

fn sample_ply(encoding: Encoding) -> Vec<u8> {
    let properties = [
        ("double", "x"),
        ("float", "y"),
        ("float", "z"),
        ("uchar", "red"),
        ("uchar", "green"),
        ("uchar", "blue"),
    ];
    let rows: Vec<Vec<f64>> = (0..40).map(|i| vec![f64::from(i); 6]).collect();
    ply(encoding, &properties, &rows)
}

fn sample_las() -> std::result::Result<Vec<(String, Vec<u8>)>, Failed> {
    let mut files = Vec::new();
    for (format, compressed) in [(3, false), (7, false), (3, true), (7, true), (10, true)] {
        let laz = if compressed { "LAZ" } else { "LAS" };
        files.push((
            format!("{laz} format {format}"),
            las_bytes(format, compressed, &points(format, 500)?)?,
        ));
    }
    Ok(files)
}

fn truncated_ply() -> std::result::Result<(), Failed> {
    for encoding in ENCODINGS {
        let whole = sample_ply(encoding);
        demand(
            read_bytes(&whole, &ReadOptions::default()).is_ok(),
            "the whole file is read",
        )?;

        // The last record of an ascii file may lack the end of its last number.
        let end = whole.len() - 8;
        for length in (1..end).step_by(7) {
            demand_sentence(&format!("{encoding:?} cut at {length}"), &whole[..length])?;
        }
    }
    Ok(())
}

fn truncated_las() -> std::result::Result<(), Failed> {
    for (name, whole) in sample_las()? {
        demand(
            read_bytes(&whole, &ReadOptions::default()).is_ok(),
            format!("{name} is read"),
        )?;

        // What follows the points of a LAZ file (its chunk table) may be missing.
        let table = if name.starts_with("LAZ") { 40 } else { 0 };
        let end = whole.len() - table;
        for length in (1..end).step_by(end / 90) {
            demand_sentence(
                &format!("{name} cut at {length} of {}", whole.len()),
                &whole[..length],
            )?;
        }
    }
    Ok(())
}

fn flipped_bits() -> std::result::Result<(), Failed> {
    let mut files = sample_las()?;
    files.extend(ENCODINGS.map(|encoding| (format!("{encoding:?}"), sample_ply(encoding))));
    for (name, whole) in files {
        // Every seventh bit of the header, and some of the rest.
        let header = whole.len().min(600) * 8;
        let rest = (header..whole.len() * 8).step_by(997);
        for bit in (0..header).step_by(7).chain(rest) {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            demand_harmless(&format!("{name} with bit {bit} flipped"), &bytes)?;
        }
    }
    Ok(())
}

fn said_of(bytes: &[u8]) -> String {
    let outcome = read_bytes(bytes, &ReadOptions::default());
    outcome.err().map_or(String::new(), |e| e.to_string())
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

fn endless_line() -> std::result::Result<(), Failed> {
    // Were the line cut where the reader stops, its rest would be the second point.
    let mut bytes =
        format!("ply\nformat ascii 1.0\nelement vertex 2\n{XYZ}end_header\n1 2 3").into_bytes();
    bytes.resize(bytes.len() + (17 << 20), b' ');
    bytes.extend(b"4 5 6\n");
    let said = said_of(&bytes);
    demand(said.contains("line 8 is longer than 16 MiB"), said)?;

    // A list of a million corners is no such line.
    let corners = " 0".repeat(1_000_000);
    let list = format!(
        "ply\nformat ascii 1.0\nelement vertex 1\n{XYZ}property list int int i\nend_header\n1 2 3 1000000{corners}\n"
    );
    let cloud = read_bytes(list.as_bytes(), &ReadOptions::default())?;
    demand(cloud.len() == 1, format!("{} points", cloud.len()))
}

fn surplus() -> std::result::Result<(), Failed> {
    let ascii = |body: &str| {
        format!("ply\nformat ascii 1.0\nelement vertex 2\n{XYZ}end_header\n{body}").into_bytes()
    };
    for (body, word) in [
        ("1 2 3\n4 5 6 7\n", "line 9 holds more"),
        ("1 2 3\n4 5 6\n7 8 9\n", "goes on after the 2 of `vertex`"),
    ] {
        let said = said_of(&ascii(body));
        demand(said.contains(word), format!("{body:?} says {said:?}"))?;
    }
    demand(
        said_of(&ascii("1 2 3\n4 5 6\n \n\n")).is_empty(),
        "blank lines",
    )?;
    for encoding in [Encoding::Little, Encoding::Big] {
        let whole = sample_ply(encoding);
        let padded = [whole.as_slice(), b"\n"].concat();
        demand(said_of(&padded).is_empty(), "less than a record is padding")?;
        let said = said_of(&[whole.as_slice(), &whole[whole.len() - 19..]].concat());
        demand(said.contains("goes on after the 40"), said)?;
    }
    let faces = format!(
        "ply\nformat ascii 1.0\nelement vertex 1\n{XYZ}element face 1\nproperty list int int i\nend_header\n1 2 3\n1 0\n"
    );
    demand(
        said_of(faces.as_bytes()).is_empty(),
        "what is promised may follow",
    )
}

fn absurd_ply_headers() -> std::result::Result<(), Failed> {
    let with = |body: &str| {
        format!("ply\nformat binary_little_endian 1.0\n{body}end_header\n0123456789").into_bytes()
    };
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let cases = [
        with(&format!("element vertex 4000000000\n{xyz}")),
        with(&format!("element vertex 18446744073709551615\n{xyz}")),
        with(&format!("element vertex 99999999999999999999\n{xyz}")),
        with(&format!("element vertex -1\n{xyz}")),
        with(&format!("element vertex\n{xyz}")),
        with("element vertex 4000000000\n"),
        with("element vertex 1\nproperty float x\nproperty float y\n"),
        with("element face 1\nproperty list uchar int vertex_indices\n"),
        with(&format!(
            "element face 4000000000\nproperty list uchar int i\nelement vertex 0\n{xyz}"
        )),
        with(&format!(
            "element vertex 1\nproperty list uchar float x\n{xyz}"
        )),
        with(&format!(
            "element vertex 1\nproperty list uint double x\n{xyz}"
        )),
        with("property float x\n"),
        with(&format!("element vertex 2\n{xyz}")),
        b"ply\n".to_vec(),
        b"ply\nend_header\n".to_vec(),
        b"ply\nformat ascii 1.0\nend_header\n".to_vec(),
        b"ply\nformat ascii 2.0.0\nelement vertex 1\nend_header\n".to_vec(),
        format!("ply\nformat quantum 1.0\nelement vertex 1\n{xyz}end_header\n1 2 3\n").into_bytes(),
        format!("ply\nformat ascii 1.0\nelement vertex 1\n{xyz}end_header\n1 2\n").into_bytes(),
        format!("ply\nformat ascii 1.0\nelement vertex 1\n{xyz}end_header\n1 2 three\n")
            .into_bytes(),
        format!("ply\nformat ascii 1.0\nelement vertex 1000000000000\n{xyz}end_header\n1 2 3\n")
            .into_bytes(),
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\n{xyz}end_header\n1 2 3\n\n\n\n\n\n\n\n\n"
        )
        .into_bytes(),
        [b"ply\ncomment ".to_vec(), vec![b'a'; 2 << 20]].concat(),
        [b"ply\n".to_vec(), vec![b'\n'; 2 << 20]].concat(),
        [b"ply\n".to_vec(), vec![0xff; 2000]].concat(),
        [
            b"ply\nformat ascii 1.0\n".to_vec(),
            b"element vertex 1\n".repeat(2000),
            b"end_header\n".to_vec(),
        ]
        .concat(),
    ];
    for (index, bytes) in cases.iter().enumerate() {
        demand_sentence(&format!("case {index}"), bytes)?;
    }
    let endless = b"element e 99999999999\n";
    let header = [
        b"ply\nformat ascii 1.0\n".as_slice(),
        endless,
        b"element vertex 1\n",
        xyz.as_bytes(),
    ]
    .concat();
    demand_harmless(
        "an element without properties",
        &[&header, b"end_header\n1 2 3\n".as_slice()].concat(),
    )
}

fn absurd_las_headers() -> std::result::Result<(), Failed> {
    for (name, whole) in sample_las()? {
        let changed = |at: usize, with: &[u8]| {
            let mut bytes = whole.clone();
            bytes[at..at + with.len()].copy_from_slice(with);
            bytes
        };
        let big = u32::MAX.to_le_bytes();
        let half = (u32::MAX / 2).to_le_bytes();
        let nan = f64::NAN.to_le_bytes();
        let cases = [
            ("4 billion points", changed(107, &big)),
            ("2 billion points", changed(107, &half)),
            ("points beyond the end", changed(96, &big)),
            ("points in the header", changed(96, &10_u32.to_le_bytes())),
            ("4 billion records", changed(100, &big)),
            ("point format 63", changed(104, &[63])),
            ("point length 0", changed(105, &[0, 0])),
            ("point length 65535", changed(105, &[255, 255])),
            ("a scale that is no number", changed(131, &nan)),
            ("a scale of 0", changed(139, &[0; 8])),
            (
                "an infinite offset",
                changed(155, &f64::INFINITY.to_le_bytes()),
            ),
            ("LAS 9.9", changed(24, &[9, 9])),
            ("header size 65535", changed(94, &[255, 255])),
        ];
        for (what, bytes) in &cases {
            demand_sentence(&format!("{name}, {what}"), bytes)?;
        }
        demand_harmless(&format!("{name}, header size 0"), &changed(94, &[0, 0]))?;
        if whole[25] == 4 {
            let mut bytes = changed(243, &1_u32.to_le_bytes());
            bytes[235..243].copy_from_slice(&(whole.len() as u64 - 70).to_le_bytes());
            let at = whole.len() - 70 + 20;
            bytes[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
            demand_harmless(&format!("{name}, an extended record of 16 EiB"), &bytes)?;
            let mut bytes = changed(107, &[0; 4]);
            bytes[247..255].copy_from_slice(&u64::MAX.to_le_bytes());
            demand_sentence(&format!("{name}, 2^64 points"), &bytes)?;
        }
        if name.starts_with("LAZ") {
            absurd_chunks(&name, &whole)?;
        }
    }
    Ok(())
}

/// Chunk tables and layers of absurd sizes.
fn absurd_chunks(name: &str, whole: &[u8]) -> std::result::Result<(), Failed> {
    let u32_at = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| whole[at + i])) as usize;
    let start = u32_at(96);
    let table = u32_at(start);
    let mut bytes = whole.to_vec();
    bytes[table + 4..table + 8].copy_from_slice(&[255; 4]);
    demand_sentence(&format!("{name}, 4 billion chunks"), &bytes)?;
    for (what, to) in [
        ("a table before the points", 1_u64),
        ("a table beyond the end", u64::MAX / 2),
    ] {
        let mut bytes = whole.to_vec();
        bytes[start..start + 8].copy_from_slice(&to.to_le_bytes());
        demand_harmless(&format!("{name}, {what}"), &bytes)?;
    }
    if !name.ends_with("format 3") {
        let layer = start + 8 + usize::from(u16::from_le_bytes([whole[105], whole[106]])) + 4;
        let mut bytes = whole.to_vec();
        bytes[layer..layer + 4].copy_from_slice(&[255; 4]);
        demand_sentence(&format!("{name}, a layer of 4 GiB"), &bytes)?;
    }
    Ok(())
}

fn no_point_files() -> std::result::Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).map(|()| path)
    };
    for (path, word) in [
        (folder.path().to_owned(), "folder"),
        (write("empty.ply", b"")?, "empty"),
        (write("short.las", b"LA")?, "LASF"),
        (write("text.ply", b"hello there")?, "ply"),
        (write("text.laz", b"hello there")?, "LAZ"),
        (
            write("photo.jpg", b"\xff\xd8\xff\xe0 and so on")?,
            "PLY, LAS and LAZ",
        ),
        (
            write("plywood.txt", b"plywood is a material")?,
            "PLY, LAS and LAZ",
        ),
    ] {
        let started = Instant::now();
        let outcome = read(&path);
        demand_bearable(word, started, &outcome)?;
        let said = outcome.err().map_or(String::new(), |e| e.to_string());
        demand(said.contains(word), format!("{}: {said}", path.display()))?;
    }
    let missing = read(&folder.path().join("missing.ply"));
    demand(
        matches!(missing, Err(Error::Read { .. })),
        "a missing file is the system's word",
    )
}

#[cfg(unix)]
fn pipe() -> std::result::Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("pipe.ply");
    let made = std::process::Command::new("mkfifo").arg(&path).status()?;
    demand(made.success(), "mkfifo makes a pipe")?;
    for path in [path.as_path(), std::path::Path::new("/dev/zero")] {
        let said = read(path).err().map_or(String::new(), |e| e.to_string());
        demand(
            said.contains("not a regular file"),
            format!("{}: {said}", path.display()),
        )?;
    }
    Ok(())
}

#[cfg(not(unix))]
fn pipe() -> std::result::Result<(), Failed> {
    Ok(())
}
