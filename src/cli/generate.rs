//! `catoptric generate`: a reference scene as files.

use std::path::Path;

use catoptric::cloud::generate::{
    CloudSource, DEFAULT_POINTS, MAX_POINTS, SceneName, generate as generate_cloud, scene_toml,
};
use catoptric::cloud::{TriangleMesh, write_ply};
use catoptric::output::{check_writable, write_atomically};
use catoptric::scene::DEFAULT_SEED;

use super::args::GenerateArgs;
use super::{Usage, terminal};

/// Writes NAME.ply and NAME.toml.
pub(super) fn generate(args: &GenerateArgs) -> anyhow::Result<()> {
    let name: SceneName = args
        .name
        .parse()
        .map_err(|e: catoptric::Error| Usage(e.to_string()))?;
    let (job, progress) = terminal::job()?;
    let mesh = args
        .mesh
        .as_ref()
        .map(|path| TriangleMesh::read(path, &job))
        .transpose()?;
    name.mirrors(mesh.as_ref())
        .map_err(|e| Usage(e.to_string()))?;

    let folder = args.output.as_deref().unwrap_or(Path::new(""));
    let (points, seed) = (
        args.points.unwrap_or(DEFAULT_POINTS),
        args.seed.unwrap_or(DEFAULT_SEED),
    );
    if !(1..=MAX_POINTS).contains(&points) {
        return Err(Usage(format!(
            "--points is {points}; it must be 1 to {MAX_POINTS}"
        ))
        .into());
    }
    let [ply, toml] = ["ply", "toml"].map(|ending| folder.join(format!("{name}.{ending}")));
    check_folder(folder, &[&ply, &toml])?;

    let cloud = generate_cloud(name, points, seed, mesh.as_ref(), &job)?;
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder).map_err(|source| catoptric::Error::Write {
            path: folder.into(),
            source,
        })?;
    }
    write_atomically(&ply, |file| {
        write_ply(file, &ply, &cloud, &job).map_err(std::io::Error::other)
    })?;
    let text = scene_toml(name, CloudSource::File(&format!("{name}.ply")));
    write_atomically(&toml, |file| file.write_all(text.as_bytes()))?;
    drop(progress);
    terminal::say(&format!("wrote {} and {}", ply.display(), toml.display()));
    Ok(())
}

/// Refuses, before any work, a folder that cannot be made or in which `files` cannot be written.
fn check_folder(folder: &Path, files: &[&Path]) -> anyhow::Result<()> {
    let is_empty = |path: &Path| path.as_os_str().is_empty();
    let nearest = folder
        .ancestors()
        .find(|path| !is_empty(path) && path.exists());
    match nearest {
        Some(path) if !path.is_dir() => Err(Usage(format!(
            "--output is a folder to write to, and {} is a file; name another place",
            path.display()
        ))
        .into()),
        Some(path) if path != folder => Ok(check_writable(&path.join("scene"))?),
        None if !is_empty(folder) => Ok(check_writable(Path::new("scene"))?),
        Some(_) | None => {
            for file in files {
                check_writable(file)?;
            }
            Ok(())
        }
    }
}
