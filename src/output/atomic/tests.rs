//! Files that are there, or not, and never half.

use super::*;

fn write(path: &Path, text: &str) -> Result<()> {
    write_atomically(path, |file| file.write_all(text.as_bytes()))
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> = entries
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

#[test]
fn a_failure_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("out");
    write(&path, "old").expect("written");
    let failed = write_atomically(&path, |file| {
        file.write_all(&[b'x'; 1 << 20])?;
        Err(io::Error::other("the disk is full"))
    });
    assert!(matches!(failed, Err(Error::Write { .. })), "got {failed:?}");
    assert_eq!(fs::read_to_string(&path).expect("the old file"), "old");
    assert_eq!(names(folder.path()), ["out"]);
}

#[test]
fn cancelling_passes_through_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let cancelled = write_atomically(&folder.path().join("out"), |_| {
        Err(io::Error::other(Error::Cancelled))
    });
    assert!(
        matches!(cancelled, Err(Error::Cancelled)),
        "got {cancelled:?}"
    );
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_missing_folder_and_a_folder_in_place_of_a_file_are_sentences() {
    let folder = tempfile::tempdir().expect("a folder");
    for path in [folder.path().join("missing/out"), folder.path().to_owned()] {
        for result in [check_writable(&path), write(&path, "x")] {
            let Err(Error::Write { source, .. }) = result else {
                panic!("{} must be refused, got {result:?}", path.display());
            };
            assert!(source.to_string().contains("folder"), "{source}");
        }
    }
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn asking_first_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    check_writable(&folder.path().join("out")).expect("writable");
    assert_eq!(names(folder.path()), [""; 0]);
}

#[cfg(unix)]
#[test]
fn links_are_kept_and_their_targets_replaced() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("deep")).expect("a folder");
    symlink("deep/link", at("first")).expect("a link");
    symlink("file", at("deep/link")).expect("a link");
    for text in ["made by way of a dangling link", "and replaced"] {
        write(&at("first"), text).expect("written");
        assert_eq!(
            fs::read_to_string(at("deep/file")).expect("the target"),
            text
        );
    }
    assert!(
        at("first").is_symlink() && at("deep/link").is_symlink(),
        "the links must still be links"
    );
}

#[cfg(unix)]
#[test]
fn links_in_a_circle_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("circle");
    std::os::unix::fs::symlink("circle", &path).expect("a link");
    assert!(
        write(&path, "x").is_err(),
        "a circle has no end to write to"
    );
}

#[cfg(unix)]
#[test]
fn an_existing_file_keeps_its_permissions_and_a_new_one_gets_those_of_new_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let mode = |path: &Path| fs::metadata(path).expect("the file").permissions().mode() & 0o777;
    let (old, new, plain) = (
        folder.path().join("old"),
        folder.path().join("new"),
        folder.path().join("plain"),
    );
    fs::write(&old, "").expect("written");
    fs::set_permissions(&old, fs::Permissions::from_mode(0o640)).expect("permissions");
    fs::write(&plain, "").expect("written");
    write(&old, "x").expect("written");
    write(&new, "x").expect("written");
    assert_eq!(mode(&old), 0o640);
    assert_eq!(mode(&new), mode(&plain), "as a file that is simply made");
}

#[cfg(target_os = "linux")]
#[test]
fn devices_pipes_and_open_files_are_written_to_directly() {
    use std::io::Read;
    use std::os::fd::AsRawFd;
    use std::os::unix::fs::FileTypeExt;

    write(Path::new("/dev/null"), "x").expect("written");
    assert!(
        fs::metadata("/dev/null")
            .expect("the device")
            .file_type()
            .is_char_device(),
        "still a device"
    );

    let (mut reader, pipe) = io::pipe().expect("a pipe");
    write(
        Path::new(&format!("/proc/self/fd/{}", pipe.as_raw_fd())),
        "through the pipe",
    )
    .expect("written");
    drop(pipe);
    let mut got = String::new();
    reader.read_to_string(&mut got).expect("text");
    assert_eq!(got, "through the pipe");

    // As /dev/stdout is after `>> file`.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("redirected");
    fs::write(&path, "before ").expect("written");
    let open = OpenOptions::new()
        .append(true)
        .open(&path)
        .expect("the file");
    write(Path::new(&format!("/dev/fd/{}", open.as_raw_fd())), "after").expect("written");
    assert_eq!(fs::read_to_string(&path).expect("the file"), "before after");
}

#[test]
fn files_appear_together_or_not_at_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let stage = || {
        let mut outputs = Outputs::default();
        for name in ["first", "second"] {
            let text = name.as_bytes();
            outputs
                .stage(&at(name), |file| file.write_all(text))
                .expect("staged");
            assert!(!at(name).exists(), "{name} is not there before all are");
        }
        outputs
    };
    drop(stage());
    assert_eq!(
        names(folder.path()),
        [""; 0],
        "what is dropped leaves nothing"
    );

    let cancelled = Job::default();
    cancelled.cancel();
    let refusal = stage().commit(&cancelled);
    assert!(matches!(refusal, Err(Error::Cancelled)), "got {refusal:?}");
    assert_eq!(names(folder.path()), [""; 0], "nor does what is cancelled");

    stage().commit(&Job::default()).expect("written");
    assert_eq!(names(folder.path()), ["first", "second"]);
    assert_eq!(fs::read(at("second")).expect("the file"), b"second");
}

#[cfg(target_os = "linux")]
#[test]
fn a_stream_gets_nothing_of_what_is_cancelled() {
    use std::io::Read;
    use std::os::fd::AsRawFd;

    let (mut reader, pipe) = io::pipe().expect("a pipe");
    let path = PathBuf::from(format!("/proc/self/fd/{}", pipe.as_raw_fd()));
    let mut outputs = Outputs::default();
    outputs
        .stage(&path, |file| file.write_all(b"half a picture"))
        .expect("staged");
    drop(outputs);
    drop(pipe);
    let mut got = String::new();
    reader.read_to_string(&mut got).expect("text");
    assert_eq!(got, "", "the reader of the pipe");
}
