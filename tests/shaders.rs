//! Every shader, without a device: it is valid, has an owner, and sees the structs that Rust writes.

use std::collections::BTreeSet;
use std::path::Path;

use catoptric::backend::gpu::{LAYOUTS, Layout, SHADERS, SHARED, Shader, link};
use libtest_mimic::Trial;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, TypeInner};

/// WebGPU's default limits.
const MAX_STORAGE_BUFFERS: usize = 8;
const MAX_INVOCATIONS: f64 = 256.0;

pub(crate) fn tests() -> Vec<Trial> {
    let test = |name: &str, check: fn()| {
        Trial::test(format!("shaders::{name}"), move || {
            check();
            Ok(())
        })
    };
    vec![
        test(
            "every_shader_is_valid_without_any_feature",
            every_shader_is_valid_without_any_feature,
        ),
        test("every_file_has_an_owner", every_file_has_an_owner),
        test("layouts_agree_with_rust", layouts_agree_with_rust),
        test("a_swapped_struct_is_noticed", a_swapped_struct_is_noticed),
        test(
            "constants_are_those_of_the_shader",
            constants_are_those_of_the_shader,
        ),
        test(
            "every_shader_stays_within_default_limits",
            every_shader_stays_within_default_limits,
        ),
    ]
}

fn module(shader: &Shader) -> Module {
    let source = link(shader.source, SHARED).expect("imports that exist");
    match naga::front::wgsl::parse_str(&source) {
        Ok(module) => module,
        Err(error) => panic!("{}", error.emit_to_string_with_path(&source, shader.name)),
    }
}

fn every_shader_is_valid_without_any_feature() {
    for shader in SHADERS {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        if let Err(error) = validator.validate(&module(shader)) {
            panic!("{}: {error:?}", shader.name);
        }
    }
}

/// Names of the .wgsl files of a folder.
fn files(folder: &str) -> BTreeSet<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let names = std::fs::read_dir(&path)
        .expect("the folder of shaders")
        .map(|f| f.expect("an entry").file_name());
    names
        .filter_map(|n| n.to_string_lossy().strip_suffix(".wgsl").map(str::to_owned))
        .collect()
}

fn every_file_has_an_owner() {
    let owned: BTreeSet<_> = SHADERS.iter().map(|s| s.name.to_owned()).collect();
    assert_eq!(
        files("shaders"),
        owned,
        "the files (left) are those of the table (right)"
    );
    let shared: BTreeSet<_> = SHARED.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(
        files("shaders/shared"),
        shared,
        "the shared files (left) are those of the table (right)"
    );
    for name in shared {
        let import = format!("#import {name}\n");
        let used = SHADERS
            .iter()
            .map(|s| s.source)
            .chain(SHARED.iter().map(|s| s.1))
            .any(|s| s.contains(&import));
        assert!(used, "nothing imports {name}");
    }
}

/// Structs that a shader is given in uniforms and buffers: name, fields with offsets, size.
fn given_structs(module: &Module) -> Vec<(String, Vec<(String, usize)>, usize)> {
    let mut found = Vec::new();
    let given = module.global_variables.iter().filter(|(_, v)| {
        let storage = matches!(v.space, AddressSpace::Storage { .. });
        storage || v.space == AddressSpace::Uniform
    });
    let mut open: Vec<_> = given.map(|(_, v)| v.ty).collect();
    while let Some(handle) = open.pop() {
        let kind = &module.types[handle];
        if let TypeInner::Array { base, .. } = kind.inner {
            open.push(base);
        }
        if let TypeInner::Struct { members, span } = &kind.inner {
            open.extend(members.iter().map(|m| m.ty));
            let fields = members
                .iter()
                .map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize))
                .collect();
            found.push((
                kind.name.clone().unwrap_or_default(),
                fields,
                *span as usize,
            ));
        }
    }
    found
}

/// What differs between a shader's structs and those of `layouts`.
fn differences(shader: &Shader, layouts: &[Layout]) -> Vec<String> {
    let mut different = Vec::new();
    for (name, fields, span) in given_structs(&module(shader)) {
        let Some(layout) = layouts.iter().find(|l| l.name == name) else {
            different.push(format!("{}: nothing in Rust is called {name}", shader.name));
            continue;
        };
        let rust: Vec<_> = layout
            .fields
            .iter()
            .map(|(n, o)| ((*n).to_owned(), *o))
            .collect();
        if (&fields, span) != (&rust, layout.size) {
            let Layout { size, .. } = layout;
            different.push(format!(
                "{name}: WGSL {fields:?} span {span}, Rust {rust:?} size {size}"
            ));
        }
    }
    different
}

fn layouts_agree_with_rust() {
    let mut compared = 0;
    for shader in SHADERS {
        compared += given_structs(&module(shader)).len();
        let different = differences(shader, LAYOUTS);
        assert!(different.is_empty(), "{}", different.join("\n"));
    }
    assert!(
        compared >= SHADERS.len(),
        "every shader has a struct of parameters"
    );
}

fn a_swapped_struct_is_noticed() {
    let wrong: Vec<_> = LAYOUTS
        .iter()
        .map(|l| {
            let mut fields = l.fields.to_vec();
            fields.swap(0, 1);
            Layout {
                fields: fields.leak(),
                ..*l
            }
        })
        .collect();
    for shader in SHADERS {
        assert!(
            !differences(shader, &wrong).is_empty(),
            "{} does not notice swapped fields",
            shader.name
        );
    }
}

fn constants_are_those_of_the_shader() {
    for shader in SHADERS {
        let module = module(shader);
        let overrides: BTreeSet<_> = module
            .overrides
            .iter()
            .filter_map(|(_, o)| o.name.as_deref())
            .collect();
        let given: BTreeSet<_> = shader.constants.iter().map(|(name, _)| *name).collect();
        assert_eq!(
            overrides, given,
            "{}: the shader's overrides (left) are those of the table (right)",
            shader.name
        );
    }
}

fn every_shader_stays_within_default_limits() {
    for shader in SHADERS {
        let module = module(shader);
        let storage = module
            .global_variables
            .iter()
            .filter(|(_, v)| matches!(v.space, AddressSpace::Storage { .. }));
        let count = storage.count();
        assert!(
            count <= MAX_STORAGE_BUFFERS,
            "{} binds {count} storage buffers",
            shader.name
        );
        let side = shader
            .constants
            .iter()
            .find(|(n, _)| n.ends_with("_GROUP"))
            .map(|(n, v)| (*n, *v));
        let invocations = match side {
            Some(("PIXEL_GROUP", side)) => side * side,
            Some((_, count)) => count,
            None => panic!("{} has no workgroup size of the table", shader.name),
        };
        assert!(
            invocations <= MAX_INVOCATIONS,
            "{} runs {invocations} threads a workgroup",
            shader.name
        );
        assert_eq!(
            module.entry_points.len(),
            1,
            "{} has one entry point",
            shader.name
        );
    }
}
