//! A graphics device that goes away while it is used.

use super::*;

/// A window that draws on any adapter; `None` where there is none, which fails where one is required.
fn on_adapter(name: &str) -> Option<Harness<'static, Viewer>> {
    if catoptric::backend::gpu::adapter_names().is_empty() {
        let required = std::env::var("CATOPTRIC_GPU").is_ok_and(|value| value == "require");
        assert!(!required, "there is no adapter");
        return None;
    }
    let start = Start {
        path: Some(folder(name).join("scene.toml")),
        choice: BackendChoice::Gpu(None),
        ..Start::default()
    };
    let mut window = Harness::builder()
        .with_size(egui::Vec2::new(1024.0, 700.0))
        .build_eframe(|context| Viewer::new(&context.egui_ctx, None, start).expect("a thread"));
    until(&mut window, "a picture", is_at_rest);
    Some(window)
}

fn number(viewer: &Viewer) -> u64 {
    viewer.shown.as_ref().expect("a frame").request.number
}

#[test]
fn a_device_that_is_lost_is_said_and_opened_anew() {
    let Some(mut window) = on_adapter("lost") else {
        return;
    };
    assert_eq!(
        window.state().opened.as_ref().expect("a scene").backend,
        "gpu"
    );
    for turn in 1..=2 {
        let before = number(window.state());
        window.state_mut().messages.clear();
        window.state().worker.lose_device();
        window.state_mut().navigator.orbit(0.2, 0.1);
        window.state_mut().touch();
        until(&mut window, "the next whole picture", |v| {
            is_at_rest(v) && number(v) > before
        });
        let messages = &window.state().messages;
        let says = |part: &str| messages.iter().filter(|(_, m)| m.contains(part)).count();
        assert_eq!(says("device failed"), 1, "loss {turn}: {messages:?}");
        assert_eq!(says("opened anew"), 1, "loss {turn}: {messages:?}");
    }
    // Where the files are read when it happens, what was shown comes back.
    window.state_mut().messages.clear();
    let before = number(window.state());
    window.state().worker.lose_device();
    window.state_mut().reload();
    until(&mut window, "the picture as it was", |v| {
        is_at_rest(v) && number(v) > before
    });
    assert!(window.state().opened.is_some());
    assert!(!window.state().messages.is_empty(), "it is said");
}
