//! Arrows, rings and knobs over the picture, by which a shape is moved, turned and made larger.
//!
//! A gizmo of our own: `transform-gizmo` asks for a newer Rust or, in its last version for ours, brings an older epaint
//! with its fonts a second time, and moves, turns and scales about the centre alone, where boxes have sides, tori tubes and
//! paraboloids a focal length.
//!
//! Every drag is measured from where it began to where the pointer is, and done to the shape as it was: nothing adds up.

mod grasp;
mod grips;
mod paint;

#[cfg(test)]
mod tests;

use eframe::egui::{self, CursorIcon, Event, Id, Key, Modifiers, Pos2, Response, Ui};

use grasp::Grasp;
use grips::Grip;

use super::handles::Handle;
use super::screen::{Screen, place};

/// What the gizmo does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Mode {
    #[default]
    Move,
    Turn,
    Scale,
}

impl Mode {
    pub(super) const ALL: [Self; 3] = [Self::Move, Self::Turn, Self::Scale];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Move => "Move",
            Self::Turn => "Turn",
            Self::Scale => "Scale",
        }
    }

    pub(super) fn key(self) -> Key {
        match self {
            Self::Move => Key::G,
            Self::Turn => Key::R,
            Self::Scale => Key::T,
        }
    }

    fn help(self) -> &'static str {
        match self {
            Self::Move => "Moves along the axes (G); again: the shape's own axes, or the scene's",
            Self::Turn => "Turns about the axes (R); again: the shape's own axes, or the scene's",
            Self::Scale => "Makes lengths larger and smaller, one by one or all (T)",
        }
    }

    fn is_offered(self, handle: &Handle) -> bool {
        match self {
            Self::Move => true,
            Self::Turn => handle.turns().contains(&true),
            Self::Scale => !handle.arms().is_empty(),
        }
    }
}

/// What came of a drag.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moved {
    /// The shape as it is now.
    pub(super) handle: Handle,
    /// Whether the drag is over: this is one change to be undone.
    pub(super) finished: bool,
}

/// Moves one shape at a time.
#[derive(Debug, Default)]
pub(super) struct Gizmo {
    mode: Mode,
    own_axes: bool,
    hovered: Option<Grip>,
    held: Option<Held>,
    /// Whether something was held in this frame, although it no longer is.
    released: bool,
}

/// A drag under way.
#[derive(Debug)]
struct Held {
    of: Id,
    grasp: Grasp,
    now: Handle,
    moved: bool,
    says: String,
}

impl Gizmo {
    /// Whether the cursor is on a part of it: a press belongs to it.
    pub(super) fn is_hovered(&self) -> bool {
        self.hovered.is_some()
    }

    /// Whether a drag is under way, or ended in this frame: drags and clicks belong to it.
    pub(super) fn is_active(&self) -> bool {
        self.held.is_some() || self.released
    }

    /// The mode that is shown for a shape: what it does not offer is none.
    fn mode_for(&self, handle: &Handle) -> Mode {
        if self.mode.is_offered(handle) {
            self.mode
        } else {
            Mode::Move
        }
    }

    fn choose(&mut self, mode: Mode) {
        self.own_axes ^= self.mode == mode && mode != Mode::Scale;
        self.mode = mode;
    }

    /// Buttons of the modes, for a panel.
    pub(super) fn buttons(&mut self, ui: &mut Ui, handle: &Handle) {
        ui.horizontal(|ui| {
            for mode in Mode::ALL {
                let chosen = self.mode_for(handle) == mode;
                let button = egui::Button::selectable(chosen, mode.name());
                let response = ui
                    .add_enabled(mode.is_offered(handle), button)
                    .on_hover_text(mode.help())
                    .on_disabled_hover_text("This shape is not turned");
                if response.clicked() {
                    self.choose(mode);
                }
            }
            let mut own = self.own_axes;
            ui.checkbox(&mut own, "own axes")
                .on_hover_text("Moves and turns along the shape's own axes instead of the scene's");
            self.own_axes = own;
        });
    }

    /// Draws it over the picture and takes the pointer where it is on one of its parts.
    ///
    /// `canvas` is what the picture is drawn on; `of` says which shape of the scene `handle` is: when another is chosen, the
    /// drag is over. To be called before the canvas looks at the pointer, which belongs to the gizmo where
    /// [`Gizmo::is_active`]. Esc takes a drag back.
    pub(super) fn interact(
        &mut self,
        ui: &Ui,
        canvas: &Response,
        screen: &Screen,
        of: Id,
        handle: &Handle,
    ) -> Option<Moved> {
        self.released = false;
        if self.held.as_ref().is_some_and(|held| held.of != of) {
            self.held = None;
        }
        if self.held.is_none() {
            self.keys(ui);
        }
        let mode = self.mode_for(handle);
        let (pointer, pressed, any_down) = ui.input(|i| {
            let pointer = i.pointer.latest_pos();
            (pointer, i.pointer.primary_pressed(), i.pointer.any_down())
        });
        let mut moved = None;
        if self.held.is_some() {
            moved = self.follow(ui, screen, pointer);
        } else {
            let parts = grips::grips(screen, handle, mode, self.own_axes);
            // A drag that began elsewhere goes over it.
            let free = canvas.contains_pointer() && (pressed || !any_down);
            let at = pointer.filter(|_| free);
            self.hovered = at.and_then(|at| grips::pick(&parts, at));
            if let (Some(grip), Some(at)) = (self.hovered, at)
                && pressed
            {
                let grasp = Grasp::new(grip, handle, self.own_axes, screen, place(at));
                self.held = grasp.map(|grasp| Held {
                    of,
                    grasp,
                    now: handle.clone(),
                    moved: false,
                    says: String::new(),
                });
            }
        }
        self.paint(ui, canvas, screen, handle, pointer);
        moved
    }

    /// A press of a mode's key chooses it; a second one the other axes.
    fn keys(&mut self, ui: &Ui) {
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let pressed = |wanted: Key| {
            let is_it = |event: &Event| {
                matches!(event, Event::Key { key, pressed: true, repeat: false, modifiers, .. }
                    if *key == wanted && modifiers.is_none())
            };
            ui.input(|i| i.events.iter().any(is_it))
        };
        for mode in Mode::ALL {
            if pressed(mode.key()) {
                self.choose(mode);
            }
        }
    }

    /// What is held follows the pointer.
    fn follow(&mut self, ui: &Ui, screen: &Screen, pointer: Option<Pos2>) -> Option<Moved> {
        let held = self.held.as_mut()?;
        let (down, in_steps) = ui.input(|i| (i.pointer.primary_down(), i.modifiers.command));
        let cancelled = ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape));
        let before = held.now.clone();
        if cancelled {
            held.now = held.grasp.start.clone();
        } else if let Some(drag) =
            pointer.and_then(|at| held.grasp.drag(screen, place(at), in_steps))
        {
            held.now = held.grasp.start.dragged(&drag);
            held.says = held.grasp.says(&drag, &held.now);
        }
        let changed = held.now != before;
        held.moved |= changed;
        let finished = cancelled || !down;
        let moved = (changed || (finished && held.moved)).then(|| Moved {
            handle: held.now.clone(),
            finished,
        });
        if finished {
            self.held = None;
            self.hovered = None;
            self.released = true;
        }
        moved
    }

    fn paint(
        &self,
        ui: &Ui,
        canvas: &Response,
        screen: &Screen,
        handle: &Handle,
        pointer: Option<Pos2>,
    ) {
        let painter = ui.painter().with_clip_rect(canvas.rect);
        // While it is dragged, the shape is where the pointer has it, also where the scene lags behind.
        let (shown, taken) = match &self.held {
            Some(held) => (&held.now, Some(held.grasp.grip)),
            None => (handle, self.hovered),
        };
        if let Some(held) = &self.held
            && let Some([through, along]) = held.grasp.line()
            && let Some(unit) = screen.unit(through)
        {
            let far = along * (unit * 4000.0);
            if let Some(ends) = screen.line(through - far, through + far) {
                paint::guide(&painter, ends);
            }
        }
        let arms = shown.arms();
        for (grip, outline) in grips::grips(screen, shown, self.mode_for(handle), self.own_axes) {
            let is_taken = taken == Some(grip);
            if self.held.is_none() || is_taken {
                paint::part(&painter, grip, &outline, &arms, is_taken);
            }
        }
        if let (Some(grip), Some(at)) = (taken, pointer) {
            let icon = if self.held.is_some() {
                CursorIcon::Grabbing
            } else {
                CursorIcon::Grab
            };
            ui.ctx().set_cursor_icon(icon);
            match &self.held {
                Some(held) => paint::say(&painter, at, &held.says),
                None => paint::say(&painter, at, &self.hint(grip, shown)),
            }
        }
    }

    /// What a part does, while the cursor is on it.
    fn hint(&self, grip: Grip, handle: &Handle) -> String {
        let axis = |i: usize| {
            let own = self.own_axes && handle.axes() != glam::DVec3::AXES;
            let names = if own {
                ["width", "height", "axis"]
            } else {
                ["x", "y", "z"]
            };
            names[i.min(2)]
        };
        let what = match grip {
            Grip::Axis(i) => format!("move along {}", axis(i)),
            Grip::Across(i) => format!("move across {}", axis(i)),
            Grip::View => "move across the view".into(),
            Grip::Ring(i) => format!("turn about {}", axis(i)),
            Grip::ViewRing => "turn about the view".into(),
            Grip::Arm(i) => match handle.arms().get(i) {
                Some(arm) => handle.measure(arm.part).name.to_owned(),
                None => String::new(),
            },
            Grip::Grow => "all lengths".into(),
        };
        format!("{what} (Ctrl: in steps)")
    }
}
