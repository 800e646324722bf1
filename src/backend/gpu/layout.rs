//! Structs that a shader also sees. Their layouts are recorded here and compared with the shader's own by a test.

/// Where the fields of a struct lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// The struct's name, the same in Rust and WGSL.
    pub name: &'static str,
    /// Size, bytes.
    pub size: usize,
    /// Name and offset (bytes) of every field, in order.
    pub fields: &'static [(&'static str, usize)],
}

/// A struct that a shader also sees.
pub trait GpuStruct: bytemuck::Pod {
    /// Its layout in Rust.
    const LAYOUT: Layout;
}

/// Records the layout of a struct that is declared elsewhere.
macro_rules! gpu_layout {
    ($name:ident { $($field:ident),* $(,)? }) => {
        impl $crate::backend::gpu::layout::GpuStruct for $name {
            const LAYOUT: $crate::backend::gpu::layout::Layout = $crate::backend::gpu::layout::Layout {
                name: stringify!($name),
                size: size_of::<$name>(),
                fields: &[$((stringify!($field), std::mem::offset_of!($name, $field))),*],
            };
        }
    };
}

/// Declares a struct that a shader also sees, and records its layout.
macro_rules! gpu_struct {
    (
        $(#[doc = $struct_doc:literal])*
        pub(super) struct $name:ident { $( $(#[doc = $doc:literal])* $field:ident : $type:ty ),* $(,)? }
    ) => {
        $(#[doc = $struct_doc])*
        #[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
        #[repr(C)]
        pub(super) struct $name { $( $(#[doc = $doc])* pub(super) $field: $type ),* }

        gpu_layout!($name { $($field),* });
    };
}

pub(super) use {gpu_layout, gpu_struct};
