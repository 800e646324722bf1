//! The scene files of generated scenes.

use super::SceneName;

/// Where a scene file takes its points from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CloudSource<'a> {
    /// A point file, relative to the scene file.
    File(&'a str),
    /// Generated when the scene is opened.
    Generated {
        /// How many points.
        points: usize,
        /// Seed of the random numbers.
        seed: u64,
        /// The bunny's mesh, relative to the scene file.
        mesh: Option<&'a str>,
    },
}

/// The scene file (TOML) of a generated scene: its points, the light and the camera of `docs/SCENES.md`.
pub fn scene_toml(name: SceneName, source: CloudSource<'_>) -> String {
    let what = match name {
        SceneName::Sphere => "A ball shows the room behind the camera, shrunk.",
        SceneName::Parabola => "A bowl shows the room upside down, from beyond its focus.",
        SceneName::Blob => "A dented ball shows most things more than once.",
        SceneName::Torus => "A tilted ring: a bulge outside, a saddle inside.",
        SceneName::Plane => "A flat mirror, turned by 20 degrees.",
        SceneName::Multi => "Several mirrors side by side, which also show each other.",
        SceneName::Bumps => "A ball covered with bumps and dents: some 200 small reflections.",
        SceneName::Bunny => "The Stanford bunny as a mirror (Stanford 3D Scanning Repository).",
    };
    let quoted = |path: &str| toml::Value::from(path).to_string();
    let cloud = match source {
        CloudSource::File(path) => format!("path = {}\n", quoted(path)),
        CloudSource::Generated { points, seed, mesh } => {
            let mesh = mesh.map_or(String::new(), |path| format!("mesh = {}\n", quoted(path)));
            format!("generate = \"{name}\"\npoints = {points}\nseed = {seed}\n{mesh}")
        }
    };
    format!("# {what}\nformat = 1\n\n[[cloud]]\n{cloud}{REST}")
}

/// What all scenes share: the mirror mark, the light, the camera and the exposure.
const REST: &str = r#"up_axis = "y"

[[cloud.mirror]]
property = "mirror"
reflectance = 1.0

[[light]]
kind = "spot"
position = [-0.6, 0.9, 0.2]
target = [1, -1, -3]
intensity = [6, 6, 6]
inner_angle_degrees = 25
outer_angle_degrees = 35

[camera]
position = [0, 0, 0.9]
target = [0, 0, -1.1]
up = [0, 1, 0]
fov_y_degrees = 60
near = 0.05
far = 10
size = [800, 600]

[settings.image]
exposure = 4.0
"#;
