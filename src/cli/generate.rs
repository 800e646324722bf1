//! `catoptric generate`: a reference scene as files.

use std::path::Path;

use catoptric::cloud::generate::{
    CloudSource, DEFAULT_POINTS, MAX_POINTS, SceneName, generate as generate_cloud, scene_toml,
};
use catoptric::cloud::{TriangleMesh, write_ply};
use catoptric::output::write_atomically;
use catoptric::scene::DEFAULT_SEED;

use super::args::GenerateArgs;
use super::folder::{check_folder, make_folder};
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
    make_folder(folder)?;
    write_atomically(&ply, |file| {
        write_ply(file, &ply, &cloud, &job).map_err(std::io::Error::other)
    })?;
    let text = scene_toml(name, CloudSource::File(&format!("{name}.ply")));
    write_atomically(&toml, |file| file.write_all(text.as_bytes()))?;
    drop(progress);
    terminal::say(&format!("wrote {} and {}", ply.display(), toml.display()));
    Ok(())
}
