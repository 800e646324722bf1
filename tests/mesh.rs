//! Triangle meshes: read from PLY files sound and broken, and sampled evenly.

#![expect(clippy::expect_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use catoptric::cloud::TriangleMesh;
use catoptric::cloud::generate::{SceneName, Shape, generate};
use catoptric::{Error, Job};
use glam::DVec3;
use libtest_mimic::{Failed, Trial};
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::generate::claim;

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = vec![
        claim(ascii_and_binary_files_give_the_same_mesh),
        claim(the_files_own_normals_are_used_where_all_are_sound),
        claim(triangles_get_points_by_their_area),
        claim(numbers_are_read_as_those_of_clouds_are),
        claim(a_broken_file_is_a_sentence),
        claim(a_damaged_file_never_panics),
        claim(what_is_no_ordinary_file_is_a_sentence),
        claim(a_cancelled_job_reads_no_mesh),
        claim(a_mesh_that_has_no_use_is_refused),
    ];
    let scans = std::env::var_os("CATOPTRIC_SCANS")
        .map(|folder| PathBuf::from(folder).join("bunny_mesh.ply"));
    let missing = scans.is_none();
    let bunny = move || the_bunny_becomes_a_mirror(&scans.ok_or("CATOPTRIC_SCANS is unset")?);
    trials.push(Trial::test("mesh::the_bunny_becomes_a_mirror", bunny).with_ignored_flag(missing));
    trials
}

/// A pyramid with a square base: a quad and four triangles.
const CORNERS: [[f32; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [2.0, 2.0, 0.0],
    [0.0, 2.0, 0.0],
    [1.0, 1.0, 1.5],
];
const FACES: [&[u8]; 5] = [
    &[0, 3, 2, 1],
    &[0, 1, 4],
    &[1, 2, 4],
    &[2, 3, 4],
    &[3, 0, 4],
];

fn ascii() -> Vec<u8> {
    let mut text = String::from(
        "ply\nformat ascii 1.0\ncomment a pyramid\nelement vertex 5\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nelement face 5\nproperty list uchar int vertex_indices\nend_header\n",
    );
    for [x, y, z] in CORNERS {
        text += &format!("{x} {y} {z} 255\n");
    }
    for face in FACES {
        let corners: Vec<String> = face.iter().map(u8::to_string).collect();
        text += &format!("{} {}\n", face.len(), corners.join(" "));
    }
    text.into_bytes()
}

/// The same with other types, an unknown element in between and another name for the corners.
fn binary(little: bool) -> Vec<u8> {
    let order = if little { "little" } else { "big" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 5\nproperty double x\nproperty double y\n\
         property double z\nelement edge 2\nproperty list ushort short ends\nproperty int weight\nelement face 5\n\
         property uchar flags\nproperty list uint ushort vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut put = |big: &[u8]| {
        if little {
            bytes.extend(big.iter().rev());
        } else {
            bytes.extend(big);
        }
    };
    for value in CORNERS.iter().flatten() {
        put(&f64::from(*value).to_be_bytes());
    }
    for _ in 0..2 {
        put(&2u16.to_be_bytes());
        put(&7i16.to_be_bytes());
        put(&(-1i16).to_be_bytes());
        put(&9i32.to_be_bytes());
    }
    for face in FACES {
        put(&[1]);
        put(&u32::try_from(face.len())
            .expect("a short face")
            .to_be_bytes());
        for &corner in face {
            put(&u16::from(corner).to_be_bytes());
        }
    }
    bytes
}

fn write(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("a temporary file");
    (folder, path)
}

fn read(bytes: &[u8]) -> Result<TriangleMesh, Error> {
    let (_folder, path) = write("mesh.ply", bytes);
    TriangleMesh::read(&path, &Job::default())
}

fn ascii_and_binary_files_give_the_same_mesh() {
    let mesh = read(&ascii()).expect("a sound file");
    assert_eq!(
        (mesh.vertices().len(), mesh.triangles().len()),
        (5, 6),
        "a quad is two triangles"
    );
    assert!(
        (mesh.normals()[4] - DVec3::Z).length() < 1e-12,
        "the tip looks up, got {}",
        mesh.normals()[4]
    );
    assert_eq!(
        read(&binary(true)).ok(),
        Some(mesh.clone()),
        "little endian"
    );
    assert_eq!(read(&binary(false)).ok(), Some(mesh), "big endian");
}

fn the_files_own_normals_are_used_where_all_are_sound() {
    let with = |normals: [&str; 3]| {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0 {}\n1 0 0 {}\n0 1 0 {}\n3 0 1 2\n",
            normals[0], normals[1], normals[2]
        );
        read(text.as_bytes())
            .expect("a sound file")
            .normals()
            .to_vec()
    };
    let own = DVec3::new(0.0, 0.6, 0.8);
    assert!(
        with(["0 3 4"; 3])
            .iter()
            .all(|n| (*n - own).length() < 1e-12),
        "the file's, made unit length"
    );
    assert_eq!(
        with(["0 3 4", "0 0 0", "0 3 4"]),
        [DVec3::Z; 3],
        "one is zero: all from the faces"
    );
}

fn triangles_get_points_by_their_area() {
    let mesh = Arc::new(read(&ascii()).expect("a sound file"));
    let surface = Shape::Mesh(mesh).surface().expect("a mesh with an area");
    let side = (1.0f64 + 1.5 * 1.5).sqrt();
    assert!(
        (surface.area() - (4.0 + 4.0 * side)).abs() < 1e-12,
        "got {}",
        surface.area()
    );
    let (mut rng, total) = (Pcg64::seed_from_u64(1), 100_000);
    let mut counts = [0u32; 6];
    for _ in 0..total {
        let p = surface.sample(&mut rng).position;
        // The base by its two halves, the sides by where they look.
        let (x, y) = (p.x - 1.0, p.y - 1.0);
        let part = match p.z.abs() < 1e-12 {
            true => usize::from(x > y),
            false => 2 + usize::from(x > y) + 2 * usize::from(x > -y),
        };
        let height = if part < 2 {
            p.z
        } else {
            p.z - 1.5 * (1.0 - x.abs().max(y.abs()))
        };
        assert!(height.abs() < 1e-12, "{p} is {height} off the pyramid");
        counts[part] += 1;
    }
    for (part, &count) in counts.iter().enumerate() {
        let area = if part < 2 { 2.0 } else { side };
        let expected = area / surface.area() * f64::from(total);
        let deviation = (f64::from(count) - expected) / expected.sqrt();
        assert!(
            deviation.abs() < 5.0,
            "part {part}: {count} points, expected {expected}"
        );
    }
}

fn replaced(from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(ascii()).expect("an ascii file");
    assert!(text.contains(from), "{from} must be in the file");
    text.replacen(from, to, 1).into_bytes()
}

fn numbers_are_read_as_those_of_clouds_are() {
    let odd = replaced(
        "0 0 0 255\n2 0 0 255\n",
        "0. .0 -0 255.\n\n2. +0 .0e1 nan\n\n",
    );
    assert_eq!(read(&odd).ok(), read(&ascii()).ok());
    let lost = read(&replaced("1 1 1.5 255", "nan 1 1.5 255")).expect("the base is left");
    assert_eq!((lost.triangles().len(), lost.skipped()), (2, 4));
    let other = read(&replaced(
        "element vertex 5",
        "element nothing 9\nelement vertex 5",
    ));
    assert_eq!(
        other.ok(),
        read(&ascii()).ok(),
        "an element without properties"
    );
}

fn a_broken_file_is_a_sentence() {
    let huge = "element face 18446744073709551615";
    for (bytes, named) in [
        (Vec::new(), "empty"),
        (b"ply\n".to_vec(), "header"),
        (b"\x89PNG\r\n\x1a\n".to_vec(), "header"),
        (replaced("element face 5", "element face five"), "header"),
        (replaced("element face 5", huge), "too short"),
        (
            replaced("element vertex 5", "element vertex 99999999"),
            "too short",
        ),
        (
            replaced("element face 5", "element face 6"),
            "ends within record 6 of `face`",
        ),
        (
            replaced("element vertex 5", "element vertex 4"),
            "line 16 holds more",
        ),
        (
            replaced("property float z", "property float w"),
            "no vertices",
        ),
        (
            replaced("property float z", "property list uchar float z"),
            "no vertices",
        ),
        (replaced("vertex_indices", "colours"), "no faces"),
        (replaced("list uchar int", "list uchar float"), "no faces"),
        (replaced("4 0 3 2 1", "4 0 3 2 5"), "names vertex 5"),
        (replaced("4 0 3 2 1", "4 0 3 2 -1"), "line 17 does not hold"),
        (
            replaced("4 0 3 2 1", "99999999 0 3 2 1"),
            "line 17 does not hold",
        ),
        (replaced("3 0 1 4", "3 0 1 4 2"), "line 18 holds more"),
        (
            replaced("element face 5", "element face 4"),
            "goes on after",
        ),
        (
            ascii()[..ascii().len() - 16].to_vec(),
            "ends within record 4 of `face`",
        ),
        (
            binary(true)[..binary(true).len() - 3].to_vec(),
            "ends within record 5 of `face`",
        ),
    ] {
        let error = read(&bytes).expect_err(named).to_string();
        assert!(error.contains(named), "{error:?} must say {named:?}");
        assert!(!error.contains('\n'), "{error:?} must be one sentence");
    }
}

fn a_damaged_file_never_panics() {
    let (_folder, path) = write("mesh.ply", &[]);
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("a temporary file");
        match TriangleMesh::read(&path, &Job::default()) {
            Err(e) => {
                let text = e.to_string();
                assert!(
                    !text.contains('\n') && !text.contains("damaged beyond"),
                    "{text}"
                );
                1
            }
            Ok(_) => 0,
        }
    };
    let mut count = 0;
    for bytes in [ascii(), binary(true), binary(false)] {
        for i in (0..bytes.len()).step_by(3) {
            count += refused(&bytes[..i]);
            let mut flipped = bytes.clone();
            flipped[i] ^= 1 << (i % 8);
            count += refused(&flipped);
        }
    }
    assert!(count > 300, "most damage must be noticed, got {count}");
}

fn what_is_no_ordinary_file_is_a_sentence() {
    let (folder, path) = write("mesh.ply", &ascii());
    let refusal = |path: &Path| {
        TriangleMesh::read(path, &Job::default())
            .expect_err("no ordinary file")
            .to_string()
    };
    assert!(refusal(folder.path()).contains("folder"), "a folder");
    assert!(
        refusal(Path::new("/dev/null")).contains("regular file"),
        "a device"
    );
    assert!(
        refusal(&path.with_extension("obj")).starts_with("cannot read"),
        "a missing file"
    );
    // A pipe that nobody writes to would wait for ever.
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if made.is_ok_and(|status| status.success()) {
        assert!(refusal(&pipe).contains("regular file"), "a pipe");
    }
}

fn a_cancelled_job_reads_no_mesh() {
    let (_folder, path) = write("mesh.ply", &ascii());
    let job = Job::default();
    job.cancel();
    assert!(
        matches!(TriangleMesh::read(&path, &job), Err(Error::Cancelled)),
        "a cancelled job"
    );
}

fn a_mesh_that_has_no_use_is_refused() {
    let mesh = read(&ascii()).expect("a sound file");
    let error =
        generate(SceneName::Sphere, 100, 1, Some(&mesh), &Job::default()).expect_err("no use");
    assert!(error.to_string().contains("no use for a mesh"), "{error}");
    let count = |mesh| SceneName::Multi.mirrors(mesh).map(|m| m.len()).ok();
    assert_eq!(
        (count(None), count(Some(&mesh))),
        (Some(5), Some(6)),
        "multi takes the mesh as its sixth mirror"
    );
}

fn the_bunny_becomes_a_mirror(path: &Path) -> Result<(), Failed> {
    let mesh = TriangleMesh::read(path, &Job::default())?;
    assert_eq!(
        (mesh.vertices().len(), mesh.triangles().len()),
        (117_570, 235_136),
        "the file's own counts"
    );
    assert_eq!(mesh.skipped(), 0, "every face has an area");
    let cloud = generate(SceneName::Bunny, 100_000, 1, Some(&mesh), &Job::default())?;
    let (low, high) = mesh
        .vertices()
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &v| {
            (low.min(v), high.max(v))
        });
    let mirror = cloud.mirror.as_ref().ok_or("no mirror mark")?;
    let on_bunny: Vec<DVec3> = cloud
        .positions
        .iter()
        .zip(mirror)
        .filter(|(_, m)| **m > 0.0)
        .map(|(p, _)| *p)
        .collect();
    let area = Shape::Mesh(Arc::new(mesh)).area()?;
    let expected = area / (area + 40.0) * 100_000.0;
    assert!(
        (on_bunny.len() as f64 - expected).abs() <= 1.0,
        "{} points, expected {expected}",
        on_bunny.len()
    );
    assert!(
        on_bunny
            .iter()
            .all(|p| p.cmpge(low).all() && p.cmple(high).all()),
        "a point outside the mesh"
    );
    Ok(())
}
