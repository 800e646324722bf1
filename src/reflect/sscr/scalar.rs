//! The numbers that the interleaved search reckons with: f32, as the GPU does, or f64, to tell what that costs.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::{DVec2, DVec3, Vec2, Vec3};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// What is done with vectors of either length.
pub trait Vector<R>:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<R, Output = Self>
{
    /// The scalar product.
    fn dot(self, other: Self) -> R;

    /// The length.
    fn length(self) -> R;
}

/// A number of the search, f32 or f64, and its vectors.
pub trait Scalar:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Two of them.
    type Vec2: Vector<Self>;
    /// Three of them.
    type Vec3: Vector<Self>;

    /// The smallest above 0 of full precision.
    const MIN_POSITIVE: Self;

    /// The number, exactly.
    fn of(value: f32) -> Self;

    /// Without its sign.
    fn abs(self) -> Self;

    /// The larger of both.
    fn max(self, other: Self) -> Self;

    /// The largest whole number that is not larger.
    fn floor(self) -> Self;

    /// The column or row that a place lies in; 0 where it lies before the first.
    fn cell(self) -> u32;

    /// A vector of these.
    fn vec2(x: Self, y: Self) -> Self::Vec2;

    /// A vector of these.
    fn vec3(x: Self, y: Self, z: Self) -> Self::Vec3;

    /// The components of a vector.
    fn parts2(v: Self::Vec2) -> [Self; 2];

    /// The components of a vector.
    fn parts3(v: Self::Vec3) -> [Self; 3];

    /// The vector, exactly.
    fn of3(v: Vec3) -> Self::Vec3;

    /// The vector product.
    fn cross(a: Self::Vec3, b: Self::Vec3) -> Self::Vec3;

    /// The direction of a vector; 0 where it has none.
    fn unit(v: Self::Vec3) -> Self::Vec3;
}

macro_rules! scalar {
    ($scalar:ty, $vec2:ty, $vec3:ty) => {
        impl Vector<$scalar> for $vec2 {
            #[inline]
            fn dot(self, other: Self) -> $scalar {
                <$vec2>::dot(self, other)
            }
            #[inline]
            fn length(self) -> $scalar {
                <$vec2>::length(self)
            }
        }

        impl Vector<$scalar> for $vec3 {
            #[inline]
            fn dot(self, other: Self) -> $scalar {
                <$vec3>::dot(self, other)
            }
            #[inline]
            fn length(self) -> $scalar {
                <$vec3>::length(self)
            }
        }

        impl Scalar for $scalar {
            type Vec2 = $vec2;
            type Vec3 = $vec3;

            const MIN_POSITIVE: Self = <$scalar>::MIN_POSITIVE;

            #[inline]
            fn of(value: f32) -> Self {
                Self::from(value)
            }
            #[inline]
            fn abs(self) -> Self {
                <$scalar>::abs(self)
            }
            #[inline]
            fn max(self, other: Self) -> Self {
                <$scalar>::max(self, other)
            }
            #[inline]
            fn floor(self) -> Self {
                <$scalar>::floor(self)
            }
            #[inline]
            fn cell(self) -> u32 {
                self as u32
            }
            #[inline]
            fn vec2(x: Self, y: Self) -> $vec2 {
                <$vec2>::new(x, y)
            }
            #[inline]
            fn vec3(x: Self, y: Self, z: Self) -> $vec3 {
                <$vec3>::new(x, y, z)
            }
            #[inline]
            fn parts2(v: $vec2) -> [Self; 2] {
                v.to_array()
            }
            #[inline]
            fn parts3(v: $vec3) -> [Self; 3] {
                v.to_array()
            }
            #[inline]
            fn of3(v: Vec3) -> $vec3 {
                <$vec3>::from(v)
            }
            #[inline]
            fn cross(a: $vec3, b: $vec3) -> $vec3 {
                a.cross(b)
            }
            #[inline]
            fn unit(v: $vec3) -> $vec3 {
                v.normalize_or_zero()
            }
        }
    };
}

scalar!(f32, Vec2, Vec3);
scalar!(f64, DVec2, DVec3);
