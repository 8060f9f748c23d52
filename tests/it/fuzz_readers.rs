//! Whatever bytes the readers of scenes, meshes, case files and histories are given, they end with a value or an error: no panic, no endless
//! loop, no more memory than the input warrants.
//!
//! Inputs are valid files, mutated and spliced. The short test runs with all others; the long one for as long as it is told:
//!
//!     FUZZ_SECONDS=3600 cargo test --release --test it fuzz_readers::for_as_long_as_told -- --ignored --nocapture
//!
//! What it finds goes to `$FUZZ_KEEP` (a folder), and from there, made small, to `tests/corpus`, which `the_corpus` reads again.

use crate::mesh_files;
use crate::pipeline_support::{DYNAMIC, STATIC};
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use thinshell::case::{self, Archive, Data, History, Kind};
use thinshell::mesh::midpoints::{Surface, place};
use thinshell::mesh::{Quality, import, validate};
use thinshell::scene;
use thinshell::snapshot::{Association, Field, Snapshot};

/// Longest time that one input may take, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// Most memory that the readers may have taken at any time [kB]; inputs are smaller than 1 MB.
const MEMORY: u64 = 2_000_000;

/// Texts of numbers that are easily forgotten, and separators.
const WORDS: &[&str] = &[
    "0",
    "-1",
    "1e999",
    "nan",
    "-inf",
    "1e-320",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "9223372036854775807",
    "-9223372036854775808",
    "99999999999999999999",
    "1e300",
    "\n",
    " ",
    "\"",
    "[",
    "]",
    "{",
    "}",
    "=",
    "<",
    ">",
    "/",
    "#",
    ",",
    "\0",
    "é",
];

struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // The low bits of such a sequence repeat soon.
        self.0 ^ (self.0 >> 32)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() >> 16) as usize % n.max(1)
    }
}

/// A valid input: extension, which says who reads it, and bytes.
type Seed = (&'static str, Vec<u8>);

fn seeds() -> Vec<Seed> {
    let mut seeds = mesh_files::all(&mesh_files::sample_with_fields());
    let mut curved = mesh_files::sample();
    place(&mut curved, Surface::Plane);
    seeds.extend(mesh_files::all_quadratic(&mesh_files::with_fields(curved)));
    for text in [include_str!("full.toml"), DYNAMIC, STATIC] {
        seeds.push(("toml", text.as_bytes().to_vec()));
    }
    for entry in ["configs", "data/mesh"].map(|folder| Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)) {
        files(&entry, &mut |path| {
            let known = ["toml", "vtk", "vtu", "vtp"].into_iter().find(|e| path.extension().is_some_and(|x| x == *e));
            seeds.extend(known.map(|extension| (extension, fs::read(path).unwrap())));
        });
    }
    let folder = tempfile::tempdir().unwrap();
    for archive in archives() {
        let path = folder.path().join("x.h5");
        archive.write(&path).unwrap();
        seeds.push(("h5", fs::read(&path).unwrap()));
    }
    seeds.push(("csv", b"step,time_s,dt_s,wall_s\n1,0.25,0.25,0.005\n2,0.5,0.25,0.008\n3,0.75,0.25,0.013\n".to_vec()));
    seeds
}

fn files(folder: &Path, visit: &mut dyn FnMut(&Path)) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() { files(&path, visit) } else { visit(&path) }
    }
}

/// Files of a case as they are written.
fn archives() -> Vec<Archive> {
    let field = |name: &str, association, components, data| Field { name: name.into(), association, components, unit: "m".into(), data };
    let snapshot = Snapshot {
        step: 3,
        time: 0.5,
        dt: 0.25,
        fields: vec![
            field("position", Association::Node, 3, (0..60).map(f64::from).collect()),
            field("director", Association::Director, 3, vec![0.5; 30]),
            field("lagged_stress", Association::Point, 6, (0..9000).map(|i| f64::from(i).sqrt()).collect()),
        ],
        numbers: vec![("newton_iterations".into(), 12.0), ("successes".into(), 3.0)],
    };
    vec![
        case::mesh_to_archive(&mesh_files::sample_with_fields(), Default::default(), "0123"),
        case::snapshot_to_archive(&snapshot, true, "0123"),
    ]
}

/// One to eight changes; now and then a part of another seed of the same kind.
fn mutate(random: &mut Random, seeds: &[Seed]) -> Seed {
    let (extension, bytes) = &seeds[random.below(seeds.len())];
    let mut bytes = bytes.clone();
    for _ in 0..=random.below(8) {
        let n = bytes.len();
        let (a, b) = (random.below(n + 1), random.below(n + 1));
        let (a, b) = (a.min(b), a.max(b));
        // Short parts as often as long ones.
        let b = if random.below(2) == 0 { b.min(a + 16) } else { b };
        match random.below(10) {
            0 => bytes.truncate(b),
            1 => drop(bytes.drain(a..b)),
            2 if n < 200_000 => {
                let part = bytes[a..b].to_vec();
                let at = random.below(n + 1);
                bytes.splice(at..at, part);
            }
            3 if n > 0 => bytes[a.min(n - 1)] ^= 1 << random.below(8),
            4 if n > 0 => bytes[a.min(n - 1)] = random.below(256) as u8,
            5 => {
                let word = WORDS[random.below(WORDS.len())].as_bytes();
                bytes.splice(a..a, word.iter().copied());
            }
            6 => {
                // A number of the text becomes another one.
                let digit = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
                if let Some(start) = bytes[a..].iter().position(u8::is_ascii_digit).map(|k| a + k) {
                    let end = bytes[start..].iter().position(|b| !digit(b)).map_or(n, |k| start + k);
                    bytes.splice(start..end, WORDS[random.below(WORDS.len())].bytes());
                }
            }
            7 if n >= 8 => {
                // A binary number becomes another one.
                let size = [1, 2, 4, 8][random.below(4)];
                let value = [0, 1, u64::MAX, 1 << 31, 1 << 32, 1 << 63, i64::MAX as u64, random.next()][random.below(8)];
                let raw = if random.below(2) == 0 { value.to_le_bytes() } else { value.to_be_bytes() };
                bytes[a.min(n - size)..][..size].copy_from_slice(&raw[..size]);
            }
            8 => {
                let (other, more) = &seeds[random.below(seeds.len())];
                if other == extension && !more.is_empty() {
                    let from = random.below(more.len());
                    let length = random.below((more.len() - from).min(4000));
                    bytes.splice(a..b, more[from..from + length].iter().copied());
                }
            }
            _ => bytes[a..b].reverse(),
        }
    }
    (extension, bytes)
}

/// A case file that is whole but does not hold what it should.
fn mutate_archive(random: &mut Random, archives: &[Archive]) -> Archive {
    let mut archive = archives[random.below(archives.len())].clone();
    for _ in 0..=random.below(4) {
        let names: Vec<String> = archive.arrays.keys().cloned().collect();
        let Some(name) = names.get(random.below(names.len())) else { break };
        let mut array = archive.arrays[name].clone();
        match random.below(8) {
            0 => {
                archive.arrays.remove(name);
                continue;
            }
            1 => array.shape = vec![array.shape.iter().product()],
            2 => array.shape.reverse(),
            3 => {
                let length = array.shape.iter().product::<usize>();
                array.data = Data::I64((0..length).map(|_| random.next() as i64 >> random.below(64)).collect());
            }
            4 => {
                let length = array.shape.iter().product::<usize>();
                array.data = Data::F64((0..length).map(|_| f64::from_bits(random.next())).collect());
            }
            5 => {
                array.shape = vec![0, 3];
                array.data = Data::F64(Vec::new());
            }
            6 => {
                let attributes: Vec<String> = array.attributes.keys().cloned().collect();
                if let Some(attribute) = attributes.get(random.below(attributes.len())) {
                    array.attributes.insert(attribute.clone(), WORDS[random.below(WORDS.len())].replace('\0', ""));
                }
            }
            _ => {
                let numbers: Vec<String> = archive.numbers.keys().cloned().collect();
                if let Some(number) = numbers.get(random.below(numbers.len())) {
                    archive.numbers.insert(number.clone(), f64::from_bits(random.next()));
                }
            }
        }
        archive.arrays.insert(name.clone(), array);
    }
    archive
}

/// Gives a file to whoever reads its kind; returns whether it was accepted.
fn read(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let accepted = match extension {
        "toml" => {
            let text = String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
            super::scene_fuzz::read(&text, &[]);
            scene::parse("fuzz.toml", &text, &[]).map(drop)
        }
        "h5" => [Kind::Mesh, Kind::Setup, Kind::Checkpoint].into_iter().try_for_each(|kind| {
            let archive = match Archive::read(path, kind) {
                Ok(archive) => archive,
                Err(error) if kind == Kind::Checkpoint => return Err(error),
                Err(_) => return Ok(()),
            };
            if let Ok(mut mesh) = case::mesh_from_archive(&archive, path) {
                let _ = validate::check(&mut mesh, "mutated");
            }
            case::snapshot_from_archive(&archive, path).map(drop)
        }),
        "csv" => {
            let _ = import::read_outline(path);
            History::read_through(path, 2).map(drop)
        }
        _ => import::read(path, 1.0).map(|(mut mesh, _)| {
            if validate::check(&mut mesh, "mutated").is_ok() {
                let _ = Quality::of(&mesh);
            }
        }),
    };
    if let Err(error) = &accepted {
        assert_eq!(error.exit_code(), 2);
        assert!(!error.to_string().is_empty());
    }
    accepted.is_ok()
}

/// Most memory that this process has had [kB], where the system tells.
fn most_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Ends the process, with the input kept, if one input takes too long.
struct Watch {
    started: Arc<Mutex<Option<Instant>>>,
}

impl Watch {
    fn new(keep: PathBuf, folder: PathBuf) -> Self {
        let started: Arc<Mutex<Option<Instant>>> = Arc::default();
        let seen = Arc::downgrade(&started);
        std::thread::spawn(move || {
            while let Some(started) = seen.upgrade() {
                if started.lock().unwrap().is_some_and(|at| at.elapsed() > PATIENCE) {
                    for entry in fs::read_dir(&folder).unwrap().flatten() {
                        let _ = fs::copy(entry.path(), keep.join(format!("endless-{}", entry.file_name().to_string_lossy())));
                    }
                    eprintln!("an input takes longer than {PATIENCE:?}; it is in {}", keep.display());
                    std::process::abort();
                }
                drop(started);
                std::thread::sleep(Duration::from_millis(200));
            }
        });
        Watch { started }
    }
}

/// Reads mutated inputs until `enough(inputs so far)`; returns how many there were, how many were accepted, and what was found.
fn fuzz(seed: u64, mut enough: impl FnMut(u64) -> bool) -> (u64, u64, Vec<String>) {
    let keep = PathBuf::from(std::env::var_os("FUZZ_KEEP").unwrap_or_else(|| std::env::temp_dir().into_os_string()));
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory).unwrap() } else { tempfile::tempdir().unwrap() };
    let watch = Watch::new(keep.clone(), folder.path().to_owned());
    let (seeds, archives) = (seeds(), archives());
    let mut random = Random(seed);
    let (mut inputs, mut accepted, mut found) = (0, 0, Vec::new());
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let mut most = most_memory();
    while !enough(inputs) {
        let path = if random.below(12) == 0 {
            let path = folder.path().join("input.h5");
            mutate_archive(&mut random, &archives).write(&path).unwrap();
            path
        } else {
            let (extension, bytes) = mutate(&mut random, &seeds);
            let path = folder.path().join(format!("input.{extension}"));
            fs::write(&path, bytes).unwrap();
            path
        };
        *watch.started.lock().unwrap() = Some(Instant::now());
        let outcome = catch_unwind(AssertUnwindSafe(|| read(&path)));
        *watch.started.lock().unwrap() = None;
        inputs += 1;
        accepted += u64::from(*outcome.as_ref().unwrap_or(&false));
        let memory = most_memory();
        if outcome.is_err() || memory > most.max(MEMORY) {
            let name = format!("found-{}-{}", COUNT.fetch_add(1, Ordering::Relaxed), path.file_name().unwrap().to_string_lossy());
            fs::copy(&path, keep.join(&name)).unwrap();
            found.push(format!("{} ({})", keep.join(name).display(), if outcome.is_err() { "panic" } else { "memory" }));
        }
        most = most.max(memory);
        fs::remove_file(&path).unwrap();
    }
    (inputs, accepted, found)
}

#[test]
fn a_thousand_and_more() {
    let (inputs, accepted, found) = fuzz(20_240_317, |inputs| inputs >= 1500);
    assert!(accepted > inputs / 50 && accepted < inputs * 9 / 10, "{accepted} of {inputs} inputs were accepted: a poor mixture");
    assert_eq!(found, Vec::<String>::new());
}

#[test]
fn the_corpus() {
    let mut read_again = 0;
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus"), &mut |path| {
        if path.extension().is_some_and(|e| e != "md") {
            let started = Instant::now();
            read(path);
            assert!(started.elapsed() < PATIENCE, "{}", path.display());
            read_again += 1;
        }
    });
    assert!(read_again > 0);
}

#[test]
#[ignore = "runs for as long as FUZZ_SECONDS says"]
fn for_as_long_as_told() {
    let number = |name: &str, default: u64| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default);
    let (seconds, seed) = (number("FUZZ_SECONDS", 60), number("FUZZ_SEED", 1));
    let (started, mut told) = (Instant::now(), 0);
    let (inputs, accepted, found) = fuzz(seed, |inputs| {
        let elapsed = started.elapsed().as_secs();
        if elapsed / 60 > told {
            told = elapsed / 60;
            println!("{told} min: {inputs} inputs, {} MB at most", most_memory() / 1000);
        }
        elapsed >= seconds
    });
    println!("{inputs} inputs, {accepted} accepted, {} MB at most; found: {found:#?}", most_memory() / 1000);
    assert_eq!(found, Vec::<String>::new());
}
