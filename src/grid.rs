//! A picture-shaped array: row by row from the top, pixel (0, 0) at the top left.

use glam::UVec2;

/// A value per pixel, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid<T> {
    size: UVec2,
    values: Vec<T>,
}

impl<T: Clone> Grid<T> {
    /// A grid of `size` (width, height) in which every pixel is `value`.
    pub fn new(size: UVec2, value: T) -> Self {
        Self {
            size,
            values: vec![value; size.x as usize * size.y as usize],
        }
    }
}

impl<T> Grid<T> {
    /// A grid from its values, row by row; `None` where their number is not width times height.
    pub fn from_vec(size: UVec2, values: Vec<T>) -> Option<Self> {
        (values.len() == size.x as usize * size.y as usize).then_some(Self { size, values })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Row length in values.
    pub fn width(&self) -> usize {
        self.size.x as usize
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.size.y as usize
    }

    /// All values, row by row.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// All values, row by row.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// The values, row by row.
    pub fn into_vec(self) -> Vec<T> {
        self.values
    }

    /// The value at column `x`, row `y`, or `None` outside.
    pub fn get(&self, x: usize, y: usize) -> Option<&T> {
        if x < self.width() {
            self.values.get(y * self.width() + x)
        } else {
            None
        }
    }
}
