//! No text, however broken, makes the reader panic.

use proptest::prelude::*;
use thinshell::scene::{self, to_toml};

const FULL: &str = include_str!("full.toml");

/// Reads; what is accepted must survive the way to text and back.
pub fn read(text: &str, overrides: &[String]) {
    match scene::parse("fuzz.toml", text, overrides) {
        Ok((scene, _)) => assert_eq!(scene::parse("again.toml", &to_toml(&scene), &[]).map(|(again, _)| again).ok(), Some(scene)),
        Err(error) => {
            assert_eq!(error.exit_code(), 2);
            assert!(!format!("{:?}", miette::Report::new(error)).is_empty());
        }
    }
}

fn token() -> impl Strategy<Value = String> {
    let keys = "mesh|rectangle|disc|size|cells|shell|thickness|region|pin|rest|linear|report|expect|measure|at|statics|dynamics|x|é";
    let signs = r#"\[|\]|\[\[|\]\]|=|\.|,|\{|\}|"|'|\n| |#|-|""""#;
    let values = "1|0|-1|1e999|nan|inf|2020-01-01|0x1F|true|\"x < 1\"|\"left\"|9223372036854775807";
    prop_oneof![3 => keys, 4 => signs, 2 => values]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn truncated_scenes(length in 0..FULL.len()) {
        read(&FULL[..length], &[]);
    }

    #[test]
    fn flipped_bytes(flips in prop::collection::vec((0..FULL.len(), any::<u8>()), 1..6)) {
        let mut bytes = FULL.as_bytes().to_vec();
        for (at, byte) in flips {
            bytes[at] = byte;
        }
        read(&String::from_utf8_lossy(&bytes), &[]);
    }

    #[test]
    fn moved_lines(from in 0..60usize, to in 0..60usize) {
        let mut lines: Vec<&str> = FULL.lines().collect();
        let line = lines.remove(from);
        lines.insert(to, line);
        read(&lines.join("\n"), &[]);
    }

    #[test]
    fn random_tokens(tokens in prop::collection::vec(token(), 0..40)) {
        read(&tokens.concat(), &[]);
    }

    #[test]
    fn random_overrides(tokens in prop::collection::vec(token(), 0..8), key in prop::sample::select(vec![
        "", "mesh=", "shell.thickness=", "pin.0.region=", "pin.1.director=", "rest.ramp=", "report.expect.0.measure=", "mesh.rectangle.cells.0=", "region.0.",
    ])) {
        read(FULL, &[format!("{key}{}", tokens.concat())]);
    }
}

#[test]
fn deep_texts() {
    for text in [
        format!("a = {}", "[".repeat(100_000)),
        format!("a = {}1{}", "{a=".repeat(50_000), "}".repeat(50_000)),
        format!("{}a = 1", "a.".repeat(50_000)),
        format!("[{}a]", "a.".repeat(50_000)),
        format!("{}\n", "[[a]]\n".repeat(50_000)),
        FULL.replace("\"2 * t\"", &format!("\"{}t\"", "(".repeat(100_000))),
    ] {
        read(&text, &[]);
        read(FULL, &[text]);
    }
    read(FULL, &["rest.ramp={a={a={a={a=1}}}}".to_owned()]);
}
