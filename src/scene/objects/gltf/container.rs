//! Opens a glTF file: its JSON and the bytes of its buffers, from the GLB itself, from files beside it, or
//! from data URIs.

use std::collections::{HashMap, HashSet};
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use ::gltf::json::Root;
use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde::Deserialize;
use serde_json::{Value, error::Category};

use crate::source::{Sources, is_step, resolve_backslashes, strip_mark};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

/// A parsed file with its buffers.
pub(super) struct Container {
    pub(super) root: Root,
    /// Nodes that are not shown, nor what is below them.
    pub(super) hidden: HashSet<usize>,
    buffers: Vec<Rc<[u8]>>,
    /// Bytes read in all.
    pub(super) bytes: u64,
}

impl Container {
    pub(super) fn open(path: &Path, sources: &Sources) -> Result<Container> {
        match is_step(path) {
            true => Container::parse(path, &sources.convert_step(path)?, sources),
            false => {
                let bytes = strip_mark(sources.bytes(path)?).map_err(|issue| issue.with_place(path))?;
                Container::parse(path, &bytes, sources)
            }
        }
    }

    /// Parses the bytes of a file, or what it was converted to.
    pub(super) fn parse(path: &Path, bytes: &[u8], sources: &Sources) -> Result<Container> {
        let place = |issue: Issue| issue.with_place(path);
        let (json, blob) = match bytes.starts_with(b"glTF") {
            true => split_glb(bytes).map_err(place)?,
            false => (bytes, None),
        };
        check_version(json).map_err(place)?;
        let root = root(json).map_err(place)?;
        // Not every exporter declares what it uses.
        let hidden = match str::from_utf8(json).is_ok_and(|json| json.contains(super::VISIBILITY)) {
            true => hidden_nodes(json).map_err(|e| place(json_issue(&e)))?,
            false => HashSet::new(),
        };
        let buffers = Vec::with_capacity(root.buffers.len());
        let mut container = Container { bytes: bytes.len() as u64, buffers, hidden, root };
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut beside = Beside { folder, sources, read: HashMap::new(), bytes: 0 };
        for (index, buffer) in container.root.buffers.iter().enumerate() {
            let bytes: Rc<[u8]> = match (&buffer.uri, blob) {
                (None, Some(blob)) if index == 0 => Ok(Rc::from(blob)),
                (None, _) => Err(Issue::damaged("has no uri and there is no binary chunk for it").into()),
                (Some(uri), _) if uri.starts_with("data:") => data_uri(uri),
                (Some(uri), _) => beside.file(uri),
            }
            .map_err(|e| e.with_place(format!("buffers[{index}]")).with_place(path))?;
            if (bytes.len() as u64) < buffer.byte_length.0 {
                let key = format!("buffers[{index}].byteLength");
                let rule = format!("only {} bytes are there", bytes.len());
                return Err(place(Issue::value(key, buffer.byte_length.0, rule)).into());
            }
            container.buffers.push(bytes);
        }
        container.bytes += beside.bytes;
        Ok(container)
    }

    /// The bytes of a buffer view and its stride, if it has one.
    pub(super) fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), Issue> {
        let view = (self.root.buffer_views.get(index))
            .ok_or_else(|| Issue::says(format!("bufferViews[{index}]")).with_advice("no such"))?;
        let number = view.buffer.value();
        let buffer = (self.buffers.get(number))
            .ok_or_else(|| Issue::value(format!("bufferViews[{index}].buffer"), number, "no such"))?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0);
        // A buffer may be longer than declared (a GLB's is padded); a view may not use the rest.
        let length = self.root.buffers[number].byte_length.0;
        match end {
            Some(end) if end <= length => {
                Ok((&buffer[start as usize..end as usize], view.byte_stride.map(|stride| stride.0)))
            }
            _ => Err(Issue::says(format!(
                "bufferViews[{index}] reaches past the {length} bytes of buffers[{number}]"
            ))),
        }
    }
}

/// What a file says of the version of the format.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Versions {
    version: String,
    min_version: Option<String>,
}

/// Refuses files of versions whose rules are others, before the rest is read by those of 2.0.
fn check_version(json: &[u8]) -> Result<(), Issue> {
    #[derive(Deserialize)]
    struct File {
        asset: Versions,
    }
    if json.trim_ascii().is_empty() {
        return Err(Issue::damaged("is empty").with_advice("export it again"));
    }
    if !json.trim_ascii_start().starts_with(b"{") {
        return Err(Issue::damaged("does not begin with a JSON object").with_advice("is it a glTF file?"));
    }
    let Versions { version, min_version } =
        serde_json::from_slice::<File>(json).map_err(|e| json_issue(&e))?.asset;
    let needed = min_version.as_ref().unwrap_or(&version);
    // A minor version adds to those before it, and says which it cannot do without.
    let is_read = match min_version {
        Some(_) => ["2", "2.0"].contains(&needed.as_str()),
        None => needed == "2" || needed.starts_with("2."),
    };
    match is_read {
        true => Ok(()),
        false => {
            Err(Issue::unsupported(format!("needs glTF {needed:.20}"))
                .with_advice("export it again as glTF 2.0"))
        }
    }
}

/// The whole file. The parser wants `nodes` of every scene, which may be left out.
fn root(json: &[u8]) -> Result<Root, Issue> {
    Root::from_slice(json).or_else(|e| {
        let mut value: Value = serde_json::from_slice(json).map_err(|e| json_issue(&e))?;
        let scenes = value.get_mut("scenes").and_then(Value::as_array_mut);
        let mut is_changed = false;
        for scene in scenes.into_iter().flatten().filter_map(Value::as_object_mut) {
            is_changed |= !scene.contains_key("nodes");
            scene.entry("nodes").or_insert(Value::Array(Vec::new()));
        }
        // The first error has the line, so that it is told if there is another one.
        Root::deserialize(value).ok().filter(|_| is_changed).ok_or_else(|| json_issue(&e))
    })
}

/// The nodes that `KHR_node_visibility` hides.
fn hidden_nodes(json: &[u8]) -> serde_json::Result<HashSet<usize>> {
    #[derive(Deserialize)]
    struct File {
        #[serde(default)]
        nodes: Vec<Node>,
    }
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Node {
        extensions: Extensions,
    }
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Extensions {
        #[serde(rename = "KHR_node_visibility")]
        visibility: Visibility,
    }
    #[derive(Deserialize)]
    #[serde(default)]
    struct Visibility {
        visible: bool,
    }
    impl Default for Visibility {
        fn default() -> Self {
            Visibility { visible: true }
        }
    }
    let nodes = serde_json::from_slice::<File>(json)?.nodes.into_iter().enumerate();
    Ok(nodes.filter(|(_, node)| !node.extensions.visibility.visible).map(|(index, _)| index).collect())
}

/// What is wrong with a file's JSON.
fn json_issue(e: &serde_json::Error) -> Issue {
    match e.classify() {
        Category::Eof => Issue::damaged("its JSON ends too early").with_advice("the file is cut off"),
        Category::Syntax => Issue::damaged(format!("its JSON is damaged: {e}")),
        Category::Data | Category::Io => Issue::damaged(format!("its JSON is not that of glTF 2.0: {e}")),
    }
}

/// The JSON and the binary chunk of a GLB. The parser's own split subtracts before it compares, and so fails
/// on a header that declares less than itself.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Issue> {
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).ok_or_else(|| Issue::says("is truncated"))?;
        Ok::<_, Issue>(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    if word(4)? != 2 {
        return Err(Issue::unsupported(format!("is glTF {}.0 by its header", word(4)?))
            .with_advice("export it again as glTF 2.0"));
    }
    let length = word(8)? as usize;
    if length > bytes.len() {
        return Err(Issue::damaged(format!(
            "GLB header says {length} bytes and the file has {}: it is truncated",
            bytes.len()
        )));
    }
    let mut chunks = Vec::new();
    let mut at = 12;
    // Chunks after the second are for extensions.
    while at < length && chunks.len() < 2 {
        let (size, kind) = (word(at)? as usize, word(at + 4)?);
        let chunk = (bytes[..length].get(at + 8..at + 8 + size)).ok_or_else(|| {
            Issue::too_large(format!("GLB chunk at byte {at} says {size} bytes"))
                .with_advice("more than are left")
        })?;
        chunks.push((kind.to_le_bytes(), chunk));
        at += 8 + size;
    }
    let chunk = |number: usize, kind: &[u8; 4]| {
        let chunk = chunks.get(number).filter(|chunk| &chunk.0 == kind)?;
        Some(chunk.1)
    };
    match chunk(0, b"JSON") {
        Some(json) => Ok((json, chunk(1, b"BIN\0"))),
        None => Err(Issue::says("GLB has no JSON as its first chunk")),
    }
}

fn data_uri(uri: &str) -> Result<Rc<[u8]>> {
    let (kind, text) = uri.split_once(',').unwrap_or((uri, ""));
    if !kind.ends_with(";base64") {
        return Err(Issue::says(format!("uri {kind:.60}…")).with_advice("data must be base64").into());
    }
    let forgiving = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    GeneralPurpose::new(&base64::alphabet::STANDARD, forgiving)
        .decode(text)
        .map(Rc::from)
        .map_err(|e| Issue::damaged(e.to_string()).with_place("base64 data").into())
}

/// Files beside the glTF, each read once however many buffers name it.
struct Beside<'a> {
    folder: &'a Path,
    sources: &'a Sources,
    /// By the place on the disk.
    read: HashMap<PathBuf, Rc<[u8]>>,
    /// Bytes read in all.
    bytes: u64,
}

impl Beside<'_> {
    /// The bytes of a file that a buffer names, which must lie in the glTF's folder or below.
    fn file(&mut self, uri: &str) -> Result<Rc<[u8]>> {
        let refused = |why: &str| Error::from(Issue::value("uri", format!("{uri:.200}"), why));
        let relative = percent_decoded(uri).ok_or_else(|| refused("is not percent-encoded UTF-8"))?;
        let first_part = uri.split('/').next().unwrap_or_default();
        let is_plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
        if first_part.contains(':') || !Path::new(&relative).components().all(is_plain) {
            return Err(refused("must name a file in the folder of the glTF or below, relative to it"));
        }
        let folder = match self.folder.as_os_str().is_empty() {
            true => Path::new("."),
            false => self.folder,
        };
        let relative = match resolve_backslashes(&folder.join(&relative)).strip_prefix(folder) {
            Ok(relative) => relative.to_path_buf(),
            Err(_) => relative.into(),
        };
        // Links are followed first, so that none leads out of the folder.
        let home = folder.canonicalize().map_err(|e| refused(&e.to_string()))?;
        let target = home.join(&relative).canonicalize().map_err(|e| refused(&e.to_string()))?;
        if !target.starts_with(&home) {
            return Err(refused("is a link out of the folder of the glTF"));
        }
        if let Some(bytes) = self.read.get(&target) {
            return Ok(bytes.clone());
        }
        let bytes = self.sources.bytes(&self.folder.join(&relative))?;
        let bytes: Rc<[u8]> = Rc::from(bytes);
        self.bytes += bytes.len() as u64;
        self.read.insert(target, bytes.clone());
        Ok(bytes)
    }
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut decoded = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [byte, after @ ..] = rest {
        rest = after;
        if *byte == b'%' {
            let [high, low, after @ ..] = rest else {
                return None;
            };
            let digit = |byte: &u8| char::from(*byte).to_digit(16);
            decoded.push((digit(high)? * 16 + digit(low)?) as u8);
            rest = after;
        } else {
            decoded.push(*byte);
        }
    }
    String::from_utf8(decoded).ok()
}
