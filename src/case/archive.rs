//! One HDF5 file: named arrays, texts and numbers, written whole and read only when undamaged.
//!
//! Layout: a seal in the user block (format version, length, checksum), the attributes `kind`, `program` and `inputs` on
//! the root, texts and numbers as further attributes of the root, arrays as datasets; a `/` in an array's name makes a group.
//! Equal contents give equal bytes. This module does not know what the arrays mean: see `convert`.

use super::{atomic, seal};
use crate::error::{Error, Result};
use hdf5::types::VarLenUnicode;
use std::collections::BTreeMap;
use std::io::Seek;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Arrays from this size on [bytes] are stored in chunks with a Fletcher checksum each, for other programs' sake.
const CHUNKED: usize = 1 << 16;
/// Size of a chunk [bytes].
const CHUNK: usize = 1 << 19;

/// Which file of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `mesh.h5`
    Mesh,
    /// `setup.h5`
    Setup,
    /// `run/step_NNNNNNNN.h5`
    Checkpoint,
    /// `modes.h5`
    Modes,
}

impl Kind {
    /// Name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Mesh => "mesh",
            Kind::Setup => "setup",
            Kind::Checkpoint => "checkpoint",
            Kind::Modes => "modes",
        }
    }

    /// The command that makes such a file anew.
    pub fn remedy(self) -> &'static str {
        match self {
            Kind::Mesh => "make it anew: thinshell mesh SCENE, or do all that is out of date: thinshell all SCENE",
            Kind::Setup => "make it anew: thinshell setup SCENE, or do all that is out of date: thinshell all SCENE",
            Kind::Modes => "make it anew: thinshell modes SCENE, or do all that is out of date: thinshell all SCENE",
            Kind::Checkpoint => "remove it and all later ones, then: thinshell run SCENE",
        }
    }

    /// [`Error::Stale`] for a file of this kind.
    pub fn stale(self, path: &Path, message: impl Into<String>) -> Error {
        Error::Stale { path: path.to_path_buf(), message: message.into(), help: self.remedy().into() }
    }
}

/// Contents of one file of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Archive {
    /// Which file of a case this is.
    pub kind: Kind,
    /// Hash of what it was made from.
    pub inputs: String,
    /// Named texts.
    pub attributes: BTreeMap<String, String>,
    /// Named numbers; a name must not be among `attributes` too.
    pub numbers: BTreeMap<String, f64>,
    /// Named arrays; `/` in a name makes a group.
    pub arrays: BTreeMap<String, Array>,
}

/// A dense array, last index fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Extent in each direction; their product is the number of entries.
    pub shape: Vec<usize>,
    /// Entries.
    pub data: Data,
    /// What it means: `unit`, `association` and the like.
    pub attributes: BTreeMap<String, String>,
}

/// Entries of an [`Array`].
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Real numbers, kept bit by bit.
    F64(Vec<f64>),
    /// Whole numbers.
    I64(Vec<i64>),
}

impl Array {
    /// Real numbers in rows of `components`.
    pub fn rows(data: Vec<f64>, components: usize) -> Self {
        let shape = vec![data.len() / components.max(1), components];
        Array { shape, data: Data::F64(data), attributes: BTreeMap::new() }
    }

    /// Indices in rows of `components`.
    pub fn indices(data: impl IntoIterator<Item = usize>, components: usize) -> Self {
        let data: Vec<i64> = data.into_iter().map(|i| i as i64).collect();
        let shape = vec![data.len() / components.max(1), components];
        Array { shape, data: Data::I64(data), attributes: BTreeMap::new() }
    }

    /// The same with a named text.
    pub fn with(mut self, name: &str, text: impl Into<String>) -> Self {
        self.attributes.insert(name.into(), text.into());
        self
    }

    /// The real numbers, if it holds such.
    pub fn as_f64(&self) -> Option<&[f64]> {
        match &self.data {
            Data::F64(v) => Some(v),
            Data::I64(_) => None,
        }
    }

    /// The whole numbers, if it holds such.
    pub fn as_i64(&self) -> Option<&[i64]> {
        match &self.data {
            Data::I64(v) => Some(v),
            Data::F64(_) => None,
        }
    }
}

impl Archive {
    /// An empty archive.
    pub fn new(kind: Kind, inputs: impl Into<String>) -> Self {
        Archive { kind, inputs: inputs.into(), attributes: BTreeMap::new(), numbers: BTreeMap::new(), arrays: BTreeMap::new() }
    }

    /// Writes the file whole or not at all.
    ///
    /// Errors: [`Error::Io`] if the system refuses, with the file of before untouched; [`Error::Input`] for names that HDF5
    /// cannot hold.
    pub fn write(&self, path: &Path) -> Result<()> {
        let cannot = |e| Error::input(path.display().to_string(), format!("cannot be stored as HDF5: {e}"));
        let mut image = self.image().map_err(cannot)?;
        seal::put(&mut image);
        atomic::write(path, &image)
    }

    /// Reads an undamaged file of the given kind.
    ///
    /// Errors: [`Error::Stale`] with the command to rerun if it is missing, foreign, of another kind or format version, cut
    /// off or changed by as little as a bit; [`Error::Io`] if the system refuses.
    pub fn read(path: &Path, kind: Kind) -> Result<Archive> {
        let mut file = match std::fs::File::open(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Err(kind.stale(path, "does not exist")),
            opened => opened.map_err(|e| Error::io("read", path, e))?,
        };
        if let Err(message) = seal::check(&mut file).map_err(|e| Error::io("read", path, e))? {
            return Err(kind.stale(path, message));
        }
        let size = file.stream_position().map_err(|e| Error::io("read", path, e))?;
        let archive = parse(path, size).map_err(|e| kind.stale(path, e.to_string()))?;
        if archive.kind != kind {
            return Err(kind.stale(path, format!("holds a {}, expected a {}", archive.kind.name(), kind.name())));
        }
        Ok(archive)
    }

    /// Reads like [`Archive::read`] and refuses a file that was made from other inputs.
    pub fn read_for(path: &Path, kind: Kind, inputs: &str) -> Result<Archive> {
        let archive = Archive::read(path, kind)?;
        if archive.inputs != inputs {
            return Err(kind.stale(path, "was made from other inputs than the present ones"));
        }
        Ok(archive)
    }

    /// Array of that name. Error: what is missing, for [`Kind::stale`].
    pub(super) fn array(&self, name: &str) -> Result<&Array, String> {
        self.arrays.get(name).ok_or_else(|| format!("has no array `{name}`"))
    }

    /// The file's bytes with room for the seal, built in memory: the library never meets a full disk.
    fn image(&self) -> hdf5::Result<Vec<u8>> {
        // Files in memory need names of their own too, where several threads write at once.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let file = hdf5::File::with_options()
            .with_fapl(|p| p.core_options(1 << 20, false))
            .with_fcpl(|p| p.userblock(seal::LENGTH as u64))
            .create(format!("archive-{}", COUNT.fetch_add(1, Ordering::Relaxed)))?;
        put_text(&file, "kind", self.kind.name())?;
        put_text(&file, "program", concat!("thinshell ", env!("CARGO_PKG_VERSION")))?;
        put_text(&file, "inputs", &self.inputs)?;
        for (name, text) in &self.attributes {
            put_text(&file, name, text)?;
        }
        for (name, number) in &self.numbers {
            file.new_attr::<f64>().create(name.as_str())?.write_scalar(number)?;
        }
        for (name, array) in &self.arrays {
            let dataset = match &array.data {
                Data::F64(v) => put_array(&file, name, &array.shape, v)?,
                Data::I64(v) => put_array(&file, name, &array.shape, v)?,
            };
            for (name, text) in &array.attributes {
                put_text(&dataset, name, text)?;
            }
        }
        file.flush()?;
        copy_image(&file)
    }
}

fn put_text(at: &hdf5::Location, name: &str, text: &str) -> hdf5::Result<()> {
    let text: VarLenUnicode = text.parse().map_err(|_| hdf5::Error::from("a text holds a NUL character"))?;
    at.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&text)
}

fn put_array<T: hdf5::H5Type>(file: &hdf5::File, name: &str, shape: &[usize], data: &[T]) -> hdf5::Result<hdf5::Dataset> {
    if shape.iter().product::<usize>() != data.len() {
        return Err(format!("array `{name}` has {} entries, its shape {shape:?} asks for another number", data.len()).into());
    }
    let builder = file.new_dataset::<T>().obj_track_times(false).create_intermediate_group(true);
    let builder = match shape {
        [rows, rest @ ..] if std::mem::size_of_val(data) >= CHUNKED => {
            let row = rest.iter().product::<usize>() * size_of::<T>();
            let chunk: Vec<usize> = [(CHUNK / row).clamp(1, *rows)].into_iter().chain(rest.iter().copied()).collect();
            builder.chunk(chunk).fletcher32()
        }
        _ => builder.no_chunk(),
    };
    let dataset = builder.shape(shape).create(name)?;
    dataset.write_raw(data)?;
    Ok(dataset)
}

/// Bytes of a file that lives in memory. The library leaves out the user block, so room for it goes before.
fn copy_image(file: &hdf5::File) -> hdf5::Result<Vec<u8>> {
    let _lock = hdf5_sys::LOCK.lock();
    // SAFETY: the lock is held, the id is that of an open file, and the library writes at most as many bytes as it is told.
    unsafe {
        let length = hdf5_sys::h5f::H5Fget_file_image(file.id(), std::ptr::null_mut(), 0);
        let length = usize::try_from(length).map_err(|_| "no image of the file")?;
        let mut image = vec![0u8; seal::LENGTH + length];
        let copied = hdf5_sys::h5f::H5Fget_file_image(file.id(), image[seal::LENGTH..].as_mut_ptr().cast(), length);
        if usize::try_from(copied) == Ok(length) { Ok(image) } else { Err("no image of the file".into()) }
    }
}

/// Reads a file whose seal is whole; `size` is its length, which no array may exceed.
fn parse(path: &Path, size: u64) -> hdf5::Result<Archive> {
    let file = hdf5::File::open(path)?;
    let (mut attributes, numbers) = attributes_of(&file)?;
    let mut take = |name: &str| attributes.remove(name).ok_or_else(|| hdf5::Error::from(format!("has no attribute `{name}`")));
    let kind = take("kind")?;
    let inputs = take("inputs")?;
    take("program")?;
    let kind = [Kind::Mesh, Kind::Setup, Kind::Checkpoint, Kind::Modes]
        .into_iter()
        .find(|k| k.name() == kind)
        .ok_or_else(|| hdf5::Error::from(format!("is of the unknown kind `{kind}`")))?;
    let mut arrays = BTreeMap::new();
    collect_arrays(&file, size, &mut arrays)?;
    Ok(Archive { kind, inputs, attributes, numbers, arrays })
}

fn collect_arrays(group: &hdf5::Group, size: u64, arrays: &mut BTreeMap<String, Array>) -> hdf5::Result<()> {
    for dataset in group.datasets()? {
        let name = dataset.name().trim_start_matches('/').to_string();
        let shape = dataset.shape();
        let bytes = shape.iter().try_fold(8u64, |n, &s| n.checked_mul(s as u64));
        if bytes.is_none_or(|b| b > size) {
            return Err(format!("array `{name}` claims to be larger than the file").into());
        }
        let data = if dataset.dtype()?.is::<f64>() { Data::F64(dataset.read_raw()?) } else { Data::I64(dataset.read_raw()?) };
        arrays.insert(name, Array { shape, data, attributes: attributes_of(&dataset)?.0 });
    }
    for inner in group.groups()? {
        collect_arrays(&inner, size, arrays)?;
    }
    Ok(())
}

type Attributes = (BTreeMap<String, String>, BTreeMap<String, f64>);

fn attributes_of(at: &hdf5::Location) -> hdf5::Result<Attributes> {
    let (mut texts, mut numbers) = Attributes::default();
    for name in at.attr_names()? {
        let attribute = at.attr(&name)?;
        if attribute.dtype()?.is::<f64>() {
            numbers.insert(name, attribute.read_scalar()?);
        } else {
            texts.insert(name, attribute.read_scalar::<VarLenUnicode>()?.to_string());
        }
    }
    Ok((texts, numbers))
}
