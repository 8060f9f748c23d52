//! Case files: every bit comes back, and no damage goes unnoticed.

use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use tempfile::TempDir;
use thinshell::Error;
use thinshell::case::{self, Archive, Array, Data, Kind};
use thinshell::mesh::{Mesh, Region};
use thinshell::snapshot::{Association, Field, Snapshot};

/// Real numbers that a careless format changes.
fn awkward() -> Vec<f64> {
    let payload = f64::from_bits(0x7ff8_dead_beef_0001);
    let signalling = f64::from_bits(0xfff0_0000_0000_0001);
    vec![0.0, -0.0, f64::NAN, payload, signalling, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE / 3.0, 0.1, f64::MAX]
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn mesh() -> Mesh {
    let mut mesh = Mesh {
        vertices: awkward().windows(3).map(Vector3::from_column_slice).collect(),
        faces: vec![[0, 1, 2], [2, 1, 3]],
        midpoints: awkward().windows(3).rev().take(5).map(Vector3::from_column_slice).collect(),
        ..Default::default()
    };
    for name in ["left", "a/b", "%2f", ".", "..", "", "größe", "left/vertices"] {
        let region = Region { vertices: vec![0, 3], edges: vec![[1, 2]], faces: vec![1] };
        mesh.regions.insert(name.into(), region);
    }
    mesh.regions.insert("empty".into(), Region::default());
    mesh
}

fn snapshot() -> Snapshot {
    let field = |name: &str, association, components, data| Field { name: name.into(), association, components, unit: "m/s".into(), data };
    Snapshot {
        step: u64::MAX,
        time: f64::from_bits(0x7ff8_0000_0000_0007),
        dt: -0.0,
        fields: vec![
            field("velocity", Association::Node, 2, awkward()),
            field("a/b", Association::Director, 1, awkward()),
            field("none", Association::Face, 6, vec![]),
            field("large", Association::Point, 3, (0..60_000).map(|i| (i as f64).sqrt()).collect()),
        ],
        numbers: vec![("z".into(), f64::NAN), ("time".into(), -0.0), ("a".into(), 1e-300)],
    }
}

fn archive() -> Archive {
    let mut archive = Archive::new(Kind::Setup, case::hash::of(&[b"inputs"]));
    archive.attributes.insert("title".into(), "two words\nand a line; ü".into());
    archive.attributes.insert("long".into(), "x".repeat(100_000));
    archive.attributes.insert("nothing".into(), String::new());
    archive.numbers.insert("worst angle".into(), 0.1 + 0.2);
    archive.arrays.insert("empty".into(), Array::rows(vec![], 3));
    archive.arrays.insert("deep/er/numbers".into(), Array::rows(awkward(), 2).with("unit", "m").with("association", "node"));
    archive.arrays.insert("scalar".into(), Array { shape: vec![], data: Data::I64(vec![i64::MIN]), attributes: BTreeMap::new() });
    archive.arrays.insert("large".into(), Array::indices(0..20_000, 2));
    archive
}

/// Equal to the bit: comparison of text, because NaN is not equal to itself, and of the bits of all numbers.
fn assert_same(a: &Archive, b: &Archive) {
    assert_eq!((a.kind, &a.inputs, &a.attributes), (b.kind, &b.inputs, &b.attributes));
    assert_eq!(format!("{:?}", a.numbers), format!("{:?}", b.numbers));
    assert_eq!(a.arrays.keys().collect::<Vec<_>>(), b.arrays.keys().collect::<Vec<_>>());
    for (name, x) in &a.arrays {
        let y = &b.arrays[name];
        assert_eq!((&x.shape, &x.attributes), (&y.shape, &y.attributes), "{name}");
        assert_eq!(x.as_i64(), y.as_i64(), "{name}");
        assert_eq!(x.as_f64().map(bits), y.as_f64().map(bits), "{name}");
    }
}

/// Message and help of a stale file, which must name its path.
fn stale(path: &Path, read: thinshell::Result<Archive>) -> (String, String) {
    match read {
        Err(Error::Stale { path: named, message, help }) => {
            assert_eq!(named, path);
            (message, help)
        }
        other => panic!("expected a stale file, got {other:?}"),
    }
}

#[test]
fn archive_comes_back_to_the_bit() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("new/setup.h5");
    archive().write(&path).unwrap();
    assert_same(&Archive::read(&path, Kind::Setup).unwrap(), &archive());
    let first = fs::read(&path).unwrap();
    archive().write(&path).unwrap();
    assert_eq!(first, fs::read(&path).unwrap(), "equal contents must give equal bytes");
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "a temporary is left");
}

#[test]
fn mesh_comes_back_to_the_bit() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("mesh.h5");
    let quality = BTreeMap::from([("smallest angle".to_string(), 0.3)]);
    case::mesh_to_archive(&mesh(), quality.clone(), "in").write(&path).unwrap();
    let read = Archive::read_for(&path, Kind::Mesh, "in").unwrap();
    assert_eq!(read.numbers, quality);
    let back = case::mesh_from_archive(&read, &path).unwrap();
    assert_eq!((&back.faces, &back.regions), (&mesh().faces, &mesh().regions));
    let flat = |m: &Mesh| m.nodes().iter().flat_map(|v| bits(v.as_slice())).collect::<Vec<_>>();
    assert_eq!(flat(&back), flat(&mesh()));
    assert_eq!(back.midpoints.len(), 5);
    let straight = Mesh { midpoints: vec![], ..mesh() };
    let archive = case::mesh_to_archive(&straight, BTreeMap::new(), "in");
    assert!(!archive.arrays.contains_key("midpoints"));
    assert!(case::mesh_from_archive(&archive, &path).unwrap().midpoints.is_empty());
    let (message, help) = stale(&path, Archive::read_for(&path, Kind::Mesh, "other"));
    assert!(message.contains("other inputs") && help.contains("thinshell mesh"), "{message}; {help}");
}

#[test]
fn mesh_with_an_index_out_of_range_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("mesh.h5");
    let mut bad = mesh();
    bad.faces[1][2] = bad.vertices.len();
    case::mesh_to_archive(&bad, BTreeMap::new(), "").write(&path).unwrap();
    let read = Archive::read(&path, Kind::Mesh).unwrap();
    assert!(matches!(case::mesh_from_archive(&read, &path), Err(Error::Stale { .. })));
}

#[test]
fn mesh_with_a_midpoint_too_few_is_refused() {
    let mut bad = mesh();
    bad.midpoints.pop();
    let archive = case::mesh_to_archive(&bad, BTreeMap::new(), "");
    match case::mesh_from_archive(&archive, Path::new("mesh.h5")) {
        Err(Error::Stale { message, .. }) => assert!(message.contains("4 rows for 5 edges"), "{message}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn snapshot_comes_back_to_the_bit() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("step.h5");
    case::snapshot_to_archive(&snapshot(), true, "in").write(&path).unwrap();
    let back = case::snapshot_from_archive(&Archive::read(&path, Kind::Checkpoint).unwrap(), &path).unwrap();
    let head = |s: &Snapshot| (s.step, s.time.to_bits(), s.dt.to_bits());
    assert_eq!(head(&back), head(&snapshot()));
    let numbers = |s: &Snapshot| s.numbers.iter().map(|(n, v)| (n.clone(), v.to_bits())).collect::<Vec<_>>();
    assert_eq!(numbers(&back), numbers(&snapshot()));
    let fields = |s: &Snapshot| {
        let of = |f: &Field| (f.name.clone(), f.association, f.components, f.unit.clone(), bits(&f.data));
        s.fields.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(fields(&back), fields(&snapshot()));
}

#[test]
fn every_cut_is_noticed() {
    let folder = TempDir::new().unwrap();
    let (path, cut) = (folder.path().join("setup.h5"), folder.path().join("cut.h5"));
    archive().write(&path).unwrap();
    let whole = fs::read(&path).unwrap();
    let lengths = (0..700).chain((700..whole.len()).step_by(997)).chain([whole.len() - 1]);
    for length in lengths {
        fs::write(&cut, &whole[..length]).unwrap();
        let (message, help) = stale(&cut, Archive::read(&cut, Kind::Setup));
        assert!(message.contains("cut off") || message.contains("empty") || message.contains("damaged"), "{length}: {message}");
        assert!(help.contains("thinshell setup"), "{help}");
    }
    fs::write(&cut, [&whole[..], b"more"].concat()).unwrap();
    assert!(stale(&cut, Archive::read(&cut, Kind::Setup)).0.contains("damaged"));
}

#[test]
fn every_flipped_bit_is_noticed() {
    let folder = TempDir::new().unwrap();
    let (path, flipped) = (folder.path().join("setup.h5"), folder.path().join("flipped.h5"));
    archive().write(&path).unwrap();
    let mut whole = fs::read(&path).unwrap();
    let offsets: Vec<usize> = (0..600).chain((600..whole.len()).step_by(613)).collect();
    for (n, offset) in offsets.into_iter().enumerate() {
        let bit = 1 << (n % 8);
        whole[offset] ^= bit;
        fs::write(&flipped, &whole).unwrap();
        stale(&flipped, Archive::read(&flipped, Kind::Setup));
        whole[offset] ^= bit;
    }
}

#[test]
fn wrong_files_are_told_apart() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("mesh.h5");
    let message = || stale(&path, Archive::read(&path, Kind::Mesh)).0;
    assert!(message().contains("does not exist"));
    fs::write(&path, "").unwrap();
    assert!(message().contains("empty"));
    fs::write(&path, "solid cube\n".repeat(100)).unwrap();
    assert!(message().contains("not a file of this program"));
    hdf5::File::create(&path).unwrap().close().unwrap();
    assert!(message().contains("HDF5 file, but not one of this program"));
    archive().write(&path).unwrap();
    assert!(message().contains("holds a setup, expected a mesh"));
    let mut newer = fs::read(&path).unwrap();
    let at = newer.windows(8).position(|w| w == b"format 1").unwrap() + 7;
    newer[at] = b'2';
    fs::write(&path, newer).unwrap();
    assert!(message().contains("format version 2; this program reads version 1"));
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    assert!(matches!(Archive::read(&path, Kind::Mesh), Err(Error::Io { .. })));
}

#[test]
fn other_programs_can_read_the_file() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("setup.h5");
    archive().write(&path).unwrap();
    let file = hdf5::File::open(&path).unwrap();
    assert_eq!(file.userblock(), 512);
    let large = file.dataset("large").unwrap();
    assert_eq!(large.shape(), [10_000, 2]);
    assert!(large.filters().contains(&hdf5::filters::Filter::Fletcher32));
    let program: hdf5::types::VarLenUnicode = file.attr("program").unwrap().read_scalar().unwrap();
    assert!(program.starts_with("thinshell "));
}

#[test]
fn a_failed_write_leaves_the_file_of_before() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("setup.h5");
    archive().write(&path).unwrap();
    let before = fs::read(&path).unwrap();
    // An array whose shape does not fit and a text that HDF5 cannot hold are refused before the file is touched.
    let mut bad = archive();
    bad.arrays.insert("bad".into(), Array { shape: vec![2, 2], data: Data::F64(vec![0.0; 3]), attributes: BTreeMap::new() });
    assert!(matches!(bad.write(&path), Err(Error::Input { .. })));
    let mut bad = archive();
    bad.attributes.insert("nul".into(), "a\0b".into());
    assert!(matches!(bad.write(&path), Err(Error::Input { .. })));
    assert_eq!(before, fs::read(&path).unwrap());
    // A folder in the file's place cannot be replaced; nothing is left beside it.
    let taken = folder.path().join("taken");
    fs::create_dir(&taken).unwrap();
    match archive().write(&taken) {
        Err(Error::Io { path, .. }) => assert_eq!(path, taken),
        other => panic!("{other:?}"),
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    // A file in the folder's place.
    assert!(matches!(archive().write(&path.join("mesh.h5")), Err(Error::Io { .. })));
}

#[test]
fn leftovers_of_dead_writers_go() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("setup.h5");
    let dead = folder.path().join(".setup.h5.tmp-4294967295");
    let alive = folder.path().join(".other.h5.tmp-1");
    let foreign = [".tmp-4294967295", "notes.tmp-4294967295", ".setup.h5.tmp-x"].map(|n| folder.path().join(n));
    for file in foreign.iter().chain([&dead, &alive]) {
        fs::write(file, "half").unwrap();
    }
    archive().write(&path).unwrap();
    assert!(!dead.exists(), "the leftover of a dead writer must go");
    assert!(foreign.iter().all(|f| f.exists()), "files of other names must stay");
    assert_eq!(alive.exists(), Path::new("/proc/1").exists(), "the temporary of a living writer must stay");
    assert_same(&Archive::read(&path, Kind::Setup).unwrap(), &archive());
}

#[test]
fn hash_depends_on_where_parts_end() {
    let hash = case::hash::of(&[b"ab", b"c"]);
    assert_eq!(hash.len(), 32);
    assert!(hash.chars().all(|c| c.is_ascii_hexdigit()));
    assert_eq!(hash, case::hash::of(&[b"ab", b"c"]));
    assert_ne!(hash, case::hash::of(&[b"a", b"bc"]));
    assert_ne!(hash, case::hash::of(&[b"abc"]));
    assert_ne!(case::hash::of(&[]), case::hash::of(&[b""]));
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("large");
    let mut bytes = vec![7; 1_000_000];
    fs::write(&path, &bytes).unwrap();
    let before = case::hash::file(&path).unwrap();
    bytes[999_999] ^= 1;
    fs::write(&path, &bytes).unwrap();
    assert_ne!(before, case::hash::file(&path).unwrap());
    assert!(matches!(case::hash::file(&folder.path().join("none")), Err(Error::Io { .. })));
}
