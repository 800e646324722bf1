//! Text out of files and arguments, made fit to be shown.

use std::fmt::Write as _;

/// `text` with everything that could steer a terminal written out, as `\u{1b}`.
pub fn printable(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        // Marks of writing direction reorder what a person reads.
        let steers = c.is_control()
            || matches!(c, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if steers {
            let _ = write!(out, "{}", c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

/// A [`printable`] name out of a file, for a message: at most 64 letters.
pub(crate) fn short_name(name: &str) -> String {
    printable(name).chars().take(64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_files_cannot_steer_the_terminal() {
        assert_eq!(
            printable("a\u{1b}[31mb\n\u{202e}c"),
            "a\\u{1b}[31mb\\n\\u{202e}c"
        );
        assert_eq!(printable("Höhe – 高さ"), "Höhe – 高さ");
    }

    #[test]
    fn names_in_messages_are_short() {
        assert_eq!(short_name(&"x".repeat(100)).len(), 64);
    }
}
