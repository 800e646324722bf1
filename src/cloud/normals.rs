//! Normals by a plane through neighbouring points.

use glam::{DMat3, DVec3, Vec3};

/// Rounds of Jacobi rotations; the off-diagonal shrinks quadratically, 3x3 needs no more.
const SWEEPS: usize = 6;

/// The second largest variance of points on a line, as a part of the largest.
const LINE_EPS: f64 = 1e-7;

/// The unit normal, of either sign, of the plane that fits `points` best (least squares); zero where the points lie
/// on a line or in one place.
pub(super) fn fitted_normal(points: impl Iterator<Item = Vec3>) -> Vec3 {
    // Sums relative to the first point, so that large coordinates cancel nothing.
    let mut points = points;
    let Some(first) = points.next() else {
        return Vec3::ZERO;
    };
    let (mut count, mut sum, mut squares) = (1.0_f64, DVec3::ZERO, DMat3::ZERO);
    for point in points {
        let p = (point - first).as_dvec3();
        count += 1.0;
        sum += p;
        squares += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
    }
    let mean = sum / count;
    let covariance =
        squares * (1.0 / count) - DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);

    let (mut variances, axes) = eigen(covariance);
    let mut order = [0, 1, 2];
    variances = variances.max(DVec3::ZERO);
    order.sort_by(|&a, &b| variances[a].total_cmp(&variances[b]));
    let [least, middle, largest] = order;
    if !(variances[largest] > 0.0) || variances[middle] <= LINE_EPS * variances[largest] {
        return Vec3::ZERO;
    }
    axes.col(least).as_vec3().normalize_or_zero()
}

/// `normal` turned to the side of `viewpoint`; where there is none, the direction to it, or up if even that has none.
pub(super) fn towards(viewpoint: Vec3, position: Vec3, normal: Vec3) -> Vec3 {
    let to_viewpoint = viewpoint - position;
    if normal == Vec3::ZERO {
        to_viewpoint.try_normalize().unwrap_or(Vec3::Z)
    } else if normal.dot(to_viewpoint) < 0.0 {
        -normal
    } else {
        normal
    }
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by Jacobi's rotations.
fn eigen(matrix: DMat3) -> (DVec3, DMat3) {
    let (mut a, mut axes) = (matrix, DMat3::IDENTITY);
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = a.col(q)[p];
            if off.abs() <= f64::MIN_POSITIVE {
                continue;
            }
            let theta = (a.col(q)[q] - a.col(p)[p]) / (2.0 * off);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(p)[p] = c;
            rotation.col_mut(q)[q] = c;
            rotation.col_mut(q)[p] = t * c;
            rotation.col_mut(p)[q] = -t * c;
            a = rotation.transpose() * a * rotation;
            axes *= rotation;
        }
    }
    (DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z), axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_rebuild_their_matrix() {
        let m = DMat3::from_cols(
            DVec3::new(4.0, 1.0, -2.0),
            DVec3::new(1.0, 3.0, 0.5),
            DVec3::new(-2.0, 0.5, 1.5),
        );
        let (values, axes) = eigen(m);
        let rebuilt = axes * DMat3::from_diagonal(values) * axes.transpose();
        let error = (rebuilt - m)
            .to_cols_array()
            .into_iter()
            .fold(0.0_f64, |e, v| e.max(v.abs()));
        assert!(error < 1e-12, "off by {error}");
    }

    #[test]
    fn a_tilted_plane_has_its_normal_far_from_the_origin_too() {
        let normal = Vec3::new(0.36, 0.48, 0.8);
        let (u, v) = normal.any_orthonormal_pair();
        let centre = Vec3::new(4096.0, -512.0, 64.0);
        let points = (0..16).map(|i| centre + u * (i % 4) as f32 + v * (i / 4) as f32);
        let fitted = fitted_normal(points);
        assert!(fitted.dot(normal).abs() > 0.999_99, "got {fitted}");
    }

    #[test]
    fn points_on_a_line_or_in_one_place_have_no_plane() {
        assert_eq!(
            fitted_normal((0..16).map(|i| Vec3::new(i as f32, 2.0 * i as f32, 0.0))),
            Vec3::ZERO
        );
        assert_eq!(fitted_normal((0..16).map(|_| Vec3::ONE)), Vec3::ZERO);
        assert_eq!(
            towards(Vec3::Y * 2.0, Vec3::ZERO, Vec3::ZERO),
            Vec3::Y,
            "the viewpoint stands in"
        );
    }
}
