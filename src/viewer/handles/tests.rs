use std::path::Path;

use catoptric::scene::Scene;
use glam::DVec2;
use proptest::prelude::*;

use super::*;

/// As a scene file says it.
fn toml(shape: &Shape) -> String {
    let v = |v: DVec3| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    let says = match shape {
        Shape::Plane {
            centre,
            normal,
            up,
            size,
        } => format!(
            "shape = \"plane\"\ncentre = {}\nnormal = {}\nup = {}\nsize = [{:?}, {:?}]",
            v(*centre),
            v(*normal),
            v(*up),
            size.x,
            size.y
        ),
        Shape::Sphere { centre, radius } => {
            format!(
                "shape = \"sphere\"\ncentre = {}\nradius = {radius:?}",
                v(*centre)
            )
        }
        Shape::Paraboloid {
            vertex,
            axis,
            focal_length,
            rim_radius,
        } => format!(
            "shape = \"paraboloid\"\nvertex = {}\naxis = {}\nfocal_length = {focal_length:?}\nrim_radius = {rim_radius:?}",
            v(*vertex),
            v(*axis)
        ),
        Shape::Torus {
            centre,
            axis,
            major_radius,
            minor_radius,
        } => format!(
            "shape = \"torus\"\ncentre = {}\naxis = {}\nmajor_radius = {major_radius:?}\nminor_radius = {minor_radius:?}",
            v(*centre),
            v(*axis)
        ),
        Shape::Blob {
            centre,
            radius,
            amplitude,
        } => format!(
            "shape = \"blob\"\ncentre = {}\nradius = {radius:?}\namplitude = {amplitude:?}",
            v(*centre)
        ),
        Shape::Bumps { centre, radius } => {
            format!(
                "shape = \"bumps\"\ncentre = {}\nradius = {radius:?}",
                v(*centre)
            )
        }
        Shape::Mesh(_) => String::new(),
    };
    format!("[[mirror]]\n{says}\n")
}

/// Says why the reader of scenes refuses a shape.
pub(in crate::viewer) fn refusal(handle: &Handle) -> Option<String> {
    let (mirror, rule) = match handle {
        Handle::Mirror(shape) => {
            if let Err(e) = shape.surface() {
                return Some(e.to_string());
            }
            (toml(shape), String::new())
        }
        Handle::Box(Bounds { min, max }) => {
            let v = |v: &DVec3| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
            let rule = format!(
                "mirror = [{{ box = {{ min = {}, max = {} }} }}]\n",
                v(min),
                v(max)
            );
            (String::new(), rule)
        }
    };
    let text = format!("format = 1\n[[cloud]]\npath = \"a.ply\"\n{rule}{mirror}");
    let read = Scene::parse(&text, Path::new("scene.toml"), &[]);
    read.err().map(|e| format!("{e}: {text}"))
}

fn plane() -> Handle {
    Handle::Mirror(Shape::Plane {
        centre: DVec3::new(1.0, 2.0, 3.0),
        normal: DVec3::Z,
        up: DVec3::Y,
        size: DVec2::new(2.0, 1.0),
    })
}

fn torus(major_radius: f64, minor_radius: f64) -> Handle {
    Handle::Mirror(Shape::Torus {
        centre: DVec3::X,
        axis: DVec3::Y,
        major_radius,
        minor_radius,
    })
}

fn unit_box() -> Handle {
    Handle::Box(Bounds {
        min: DVec3::new(0.1, 0.2, 0.3),
        max: DVec3::new(1.1, 1.2, 1.3),
    })
}

/// Any shape that a scene can hold.
pub(in crate::viewer) fn any_handle() -> impl Strategy<Value = Handle> {
    let place = prop_oneof![
        prop::array::uniform3(-10.0..10.0f64),
        prop::array::uniform3(-6e6..6e6f64),
        prop::array::uniform3(-1e15..1e15f64),
    ];
    let lengths = prop::array::uniform3(prop_oneof![
        4 => 0.01..10.0f64,
        1 => (-11.0..12.0f64).prop_map(|e| 10f64.powf(e)),
    ]);
    let axis = prop::array::uniform3(-1.0..1.0f64);
    (0..7, place, lengths, axis, 0.0..0.9f64).prop_map(|(kind, place, l, axis, amplitude)| {
        let centre = DVec3::from_array(place);
        let axis = DVec3::from_array(axis).normalize_or(DVec3::Z);
        Handle::Mirror(match kind {
            0 => Shape::Plane {
                centre,
                normal: axis,
                up: axis.any_orthonormal_vector(),
                size: DVec2::new(l[0], l[1]),
            },
            1 => Shape::Sphere {
                centre,
                radius: l[0],
            },
            2 => Shape::Paraboloid {
                vertex: centre,
                axis,
                focal_length: l[0],
                // A bowl that is deeper by far is no mirror, and has an area that no number holds.
                rim_radius: l[1].clamp(l[0] * 1e-3, l[0] * 1e3),
            },
            3 => Shape::Torus {
                centre,
                axis,
                major_radius: l[0],
                minor_radius: l[0] * (amplitude + 0.09),
            },
            4 => Shape::Blob {
                centre,
                radius: l[0],
                amplitude,
            },
            5 => Shape::Bumps {
                centre,
                radius: l[0],
            },
            _ => {
                let max = (centre + DVec3::from_array(l)).min(DVec3::splat(1e15));
                return Handle::Box(Bounds { min: centre, max });
            }
        })
    })
}

fn any_drag() -> impl Strategy<Value = Drag> {
    let number = prop_oneof![
        6 => -5.0..5.0f64,
        2 => -1e7..1e7f64,
        1 => any::<f64>(),
    ];
    let part = prop_oneof![
        Just(Part::Radius),
        Just(Part::RimRadius),
        Just(Part::FocalLength),
        Just(Part::MajorRadius),
        Just(Part::MinorRadius),
        (0..3usize, any::<bool>()).prop_map(|(axis, upper)| Part::Side { axis, upper }),
    ];
    (0..4, prop::array::uniform3(number.clone()), number, part).prop_map(
        |(kind, vector, number, part)| match kind {
            0 => Drag::Shift(DVec3::from_array(vector)),
            1 => Drag::Turn {
                axis: DVec3::from_array(vector),
                angle: number,
            },
            2 => Drag::Pull(part, number),
            _ => Drag::Grow(number),
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]

    #[test]
    fn whatever_is_dragged_a_scene_can_hold(
        handle in any_handle(),
        drags in prop::collection::vec(any_drag(), 1..8),
    ) {
        prop_assert_eq!(refusal(&handle), None, "before all drags");
        let mut dragged = handle;
        for drag in &drags {
            dragged = dragged.dragged(drag);
            prop_assert_eq!(refusal(&dragged), None, "{:?} after {:?}", dragged, drag);
        }
    }

    #[test]
    fn what_is_not_dragged_stays_to_the_bit(handle in any_handle(), axis in 0..3usize) {
        let parts = handle.arms().into_iter().map(|arm| Drag::Pull(arm.part, 0.0));
        let nothing = [
            Drag::Shift(DVec3::ZERO),
            Drag::Turn { axis: DVec3::AXES[axis], angle: 0.0 },
            Drag::Grow(1.0),
            Drag::Shift(DVec3::NAN),
            Drag::Grow(f64::INFINITY),
        ];
        for drag in parts.chain(nothing) {
            prop_assert_eq!(&handle.dragged(&drag), &handle, "{:?}", drag);
        }
        if let Some(mirror) = handle.mirror() {
            prop_assert_eq!(Handle::of_mirror(&mirror), Some(handle));
        }
    }

    #[test]
    fn own_axes_are_a_right_handed_system(handle in any_handle()) {
        let [x, y, z] = handle.axes();
        prop_assert!(x.cross(y).distance(z) < 1e-9 && (x.length() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_plane_turned_by_a_quarter_about_y_looks_along_x() {
    let turned = plane().dragged(&Drag::Turn {
        axis: DVec3::Y * 3.0,
        angle: std::f64::consts::FRAC_PI_2,
    });
    let Handle::Mirror(Shape::Plane {
        centre,
        normal,
        up,
        size,
    }) = turned
    else {
        panic!("{turned:?} is no plane");
    };
    assert!(normal.distance(DVec3::X) < 1e-12 && up.distance(DVec3::Y) < 1e-12);
    assert_eq!(
        (centre, size),
        (DVec3::new(1.0, 2.0, 3.0), DVec2::new(2.0, 1.0))
    );
}

#[test]
fn a_plane_keeps_the_edge_opposite_to_the_one_that_is_pulled() {
    for (upper, centre) in [(true, 1.5), (false, 0.5)] {
        let pulled = plane().dragged(&Drag::Pull(Part::Side { axis: 0, upper }, 1.0));
        let expected = Handle::Mirror(Shape::Plane {
            centre: DVec3::new(centre, 2.0, 3.0),
            normal: DVec3::Z,
            up: DVec3::Y,
            size: DVec2::new(3.0, 1.0),
        });
        assert_eq!(pulled, expected);
    }
}

#[test]
fn a_side_of_a_box_is_pulled_and_the_other_five_stay() {
    let Handle::Box(before) = unit_box() else {
        panic!("a box")
    };
    let pulled = unit_box().dragged(&Drag::Pull(
        Part::Side {
            axis: 2,
            upper: false,
        },
        0.5,
    ));
    let Handle::Box(after) = pulled else {
        panic!("a box")
    };
    assert_eq!(after.max, before.max);
    assert_eq!(after.min.truncate(), before.min.truncate());
    assert!((after.min.z - -0.2).abs() < 1e-12, "{after:?}");
    // Pushed through the other side, little of it is left.
    let pushed = unit_box().dragged(&Drag::Pull(
        Part::Side {
            axis: 0,
            upper: true,
        },
        -9.0,
    ));
    let Handle::Box(after) = pushed else {
        panic!("a box")
    };
    assert!(
        (after.size().x - 1e-3).abs() < 1e-12 && after.min == before.min,
        "{after:?}"
    );
}

#[test]
fn the_tube_of_a_torus_stays_thinner_than_its_ring() {
    let thick = torus(1.0, 0.2).dragged(&Drag::Pull(Part::MinorRadius, 5.0));
    assert!(
        (thick.measure(Part::MinorRadius).length - 1.0 / 1.001).abs() < 1e-12,
        "{thick:?}"
    );
    let narrow = torus(1.0, 0.2).dragged(&Drag::Pull(Part::MajorRadius, -5.0));
    assert!(
        (narrow.measure(Part::MajorRadius).length - 0.2 * 1.001).abs() < 1e-12,
        "{narrow:?}"
    );
    let grown = torus(1.0, 0.25).dragged(&Drag::Grow(2.0));
    assert_eq!(grown, torus(2.0, 0.5));
}

#[test]
fn balls_and_boxes_are_not_turned() {
    let ball = Handle::Mirror(Shape::Sphere {
        centre: DVec3::X,
        radius: 0.5,
    });
    let turn = Drag::Turn {
        axis: DVec3::Z,
        angle: 1.0,
    };
    for handle in [ball, unit_box()] {
        assert_eq!(handle.turns(), [false; 3]);
        assert_eq!(handle.dragged(&turn), handle);
    }
}

#[test]
fn a_shape_is_pulled_by_none_but_its_own_lengths() {
    for handle in [plane(), torus(1.0, 0.2), unit_box()] {
        for arm in handle.arms() {
            let before = handle.measure(arm.part).length;
            let after = handle
                .dragged(&Drag::Pull(arm.part, 0.25))
                .measure(arm.part)
                .length;
            assert!((after - before - 0.25).abs() < 1e-12, "{handle:?}: {arm:?}");
        }
        assert_eq!(handle.dragged(&Drag::Pull(Part::FocalLength, 0.25)), handle);
    }
}

#[test]
fn arms_lie_on_the_shape_and_point_outwards() {
    let bowl = Handle::Mirror(Shape::Paraboloid {
        vertex: DVec3::ZERO,
        axis: DVec3::Z,
        focal_length: 0.25,
        rim_radius: 1.0,
    });
    // By its formula, the rim of the bowl is 1 / (4 * 0.25) high.
    let rim = bowl
        .arms()
        .into_iter()
        .filter(|arm| arm.part == Part::RimRadius);
    let heights: Vec<f64> = rim.map(|arm| arm.at.z).collect();
    assert_eq!(heights, [1.0; 4]);
    for handle in [plane(), torus(1.0, 0.2), unit_box(), bowl] {
        for arm in handle.arms() {
            let longer = handle.dragged(&Drag::Pull(arm.part, 0.5));
            let next = longer
                .arms()
                .into_iter()
                .find(|a| a.part == arm.part && a.direction == arm.direction);
            let out = next.expect("the same arm").at - arm.at;
            assert!(
                out.dot(arm.direction) > 0.49,
                "{handle:?}: {arm:?} went {out}"
            );
        }
    }
}
