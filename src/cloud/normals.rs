//! Normals by a plane through neighbouring points.

use glam::{DMat3, DVec3, Vec3};

/// Most rounds of Jacobi rotations; the off-diagonal shrinks quadratically, 3x3 needs no more.
const MAX_SWEEPS: usize = 6;

/// Squares of the off-diagonal, as a part of the diagonal's, at which nothing is left to do.
const SOLVED: f64 = 1e-24;

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
    let mut a = matrix.to_cols_array_2d();
    let mut axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for _ in 0..MAX_SWEEPS {
        let off = a[1][0].powi(2) + a[2][0].powi(2) + a[2][1].powi(2);
        let diagonal = a[0][0].powi(2) + a[1][1].powi(2) + a[2][2].powi(2);
        if off <= SOLVED * diagonal {
            break;
        }
        for (p, q, other) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            if a[p][q] == 0.0 {
                continue;
            }
            // The smaller of the two angles that bring a[p][q] to zero.
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let tan = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cos = 1.0 / (tan * tan + 1.0).sqrt();
            let sin = tan * cos;
            a[p][p] -= tan * a[p][q];
            a[q][q] += tan * a[p][q];
            (a[p][q], a[q][p]) = (0.0, 0.0);
            let (with_p, with_q) = (a[other][p], a[other][q]);
            a[other][p] = cos * with_p - sin * with_q;
            a[other][q] = sin * with_p + cos * with_q;
            (a[p][other], a[q][other]) = (a[other][p], a[other][q]);
            (axes[p], axes[q]) = (cos * axes[p] - sin * axes[q], sin * axes[p] + cos * axes[q]);
        }
    }
    (
        DVec3::new(a[0][0], a[1][1], a[2][2]),
        DMat3::from_cols(axes[0], axes[1], axes[2]),
    )
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
