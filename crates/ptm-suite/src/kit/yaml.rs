//! Reads and writes YAML.
//!
//! A file is parsed into a tree of nodes with line numbers, and records are deserialized from the tree, so that every
//! error names its line. Size and depth are limited. Anchors, aliases and tags are rejected.

use std::collections::HashSet;
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use granit_parser::{Event, Parser, ScalarStyle};
use serde::Serialize;
use serde::de::value::{MapAccessDeserializer, MapDeserializer, SeqDeserializer};
use serde::de::{self, DeserializeOwned, Deserializer, IntoDeserializer, Unexpected, Visitor};
use serde::forward_to_deserialize_any;

use crate::error::{Error, Result};
use crate::kit::strip_os_error_code;

/// Maximum size of a file in bytes. Large enough for about 200,000 cases.
const MAX_BYTES: u64 = 64 << 20;
/// Maximum number of nodes in a file.
const MAX_NODES: usize = 8_000_000;
/// Maximum nesting depth of lists and mappings.
const MAX_DEPTH: usize = 16;

/// Reads a text file that the user named.
///
/// # Errors
/// Returns a message that names the file.
#[expect(
    clippy::naive_bytecount,
    reason = "files are small where bytes are counted"
)]
pub fn read_text(path: &Path) -> Result<String> {
    let with_path = |error: &dyn fmt::Display| {
        Error::Unreadable(strip_os_error_code(error)).in_place(path.display())
    };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| with_path(&error))?;
    file.take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| with_path(&error))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(with_path(&format!(
            "the file is larger than {} MiB",
            MAX_BYTES >> 20
        )));
    }
    String::from_utf8(bytes).map_err(|error| {
        let end = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..end]
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count();
        with_path(&format!("line {line}: not UTF-8"))
    })
}

/// Parses a single value.
///
/// # Errors
/// Returns a message that names the offending line.
pub fn from_yaml<T: DeserializeOwned>(text: &str) -> Result<T> {
    Ok(T::deserialize(&parse(text)?)?)
}

/// Parses embedded files, given as names and contents.
///
/// # Errors
/// Returns a message that names the file and the offending line.
pub fn from_files<T: DeserializeOwned>(files: &[(&str, &str)]) -> Result<Vec<T>> {
    let read =
        |(name, text): &(&str, &str)| from_yaml(text).map_err(|error: Error| error.in_place(name));
    files.iter().map(read).collect()
}

/// Parses a list of records, each with the number of its first line. An empty file is an empty list.
///
/// # Errors
/// Returns a message that names the offending line.
pub fn records<T: DeserializeOwned>(text: &str) -> Result<Vec<(usize, T)>> {
    let Node { line, value } = parse(text)?;
    let nodes = match value {
        Value::List(nodes) => nodes,
        Value::Scalar { text, plain: true } if text.is_empty() => Vec::new(),
        _ => return Error::at_line(line, "expected a list"),
    };
    let record = |node: &Node| Ok((node.line, T::deserialize(node)?));
    let records: Result<_, YamlError> = nodes.iter().map(record).collect();
    Ok(records?)
}

/// Serializes a value.
///
/// # Errors
/// Returns an error if YAML cannot represent the value, which does not happen for the values of this program.
pub fn to_yaml(value: &impl Serialize) -> Result<String> {
    serde_saphyr::to_string(value).map_err(|error| Error::Invalid(error.to_string().into()))
}

/// A scalar, list or mapping, with the number of its first line, counted from 1.
struct Node {
    line: usize,
    value: Value,
}

enum Value {
    /// A scalar. An unquoted (`plain`) scalar may be a number, a Boolean or null.
    Scalar {
        text: String,
        plain: bool,
    },
    List(Vec<Node>),
    Map(Vec<(Node, Node)>),
}

/// An error and its line number, which is 0 while the line is unknown.
#[derive(Debug)]
struct YamlError {
    line: usize,
    message: String,
}

impl fmt::Display for YamlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.message)
    }
}

impl std::error::Error for YamlError {}

impl From<YamlError> for Error {
    fn from(YamlError { line, message }: YamlError) -> Error {
        Error::Yaml { line, message }
    }
}

impl de::Error for YamlError {
    fn custom<T: fmt::Display>(message: T) -> YamlError {
        YamlError {
            line: 0,
            message: message.to_string(),
        }
    }
}

/// Error message for an anchor or an alias.
const NO_ANCHORS: &str = "anchors and aliases are not supported";

fn parse(text: &str) -> Result<Node> {
    let mut open: Vec<(Node, Option<Node>)> = Vec::new();
    let mut root: Option<Node> = None;
    let (mut nodes, mut documents) = (0, 0);
    for next in Parser::new_from_str(text) {
        let (event, span) = next.map_err(|error| {
            let message = match error.info() {
                info if info.ends_with("unknown anchor") => NO_ANCHORS.to_owned(),
                info => info,
            };
            let line = error.marker().line();
            Error::Yaml { line, message }
        })?;
        let line = span.start.line();
        let refuse = |why: &str| Error::at_line(line, why);
        let value = match event {
            Event::Scalar(_, _, 1.., _)
            | Event::SequenceStart(_, 1.., _)
            | Event::MappingStart(_, 1.., _)
            | Event::Alias(_) => return refuse(NO_ANCHORS),
            Event::Scalar(_, _, _, Some(_))
            | Event::SequenceStart(_, _, Some(_))
            | Event::MappingStart(_, _, Some(_)) => return refuse("tags are not supported"),
            Event::Scalar(text, style, ..) => Value::Scalar {
                text: text.into_owned(),
                plain: style == ScalarStyle::Plain,
            },
            Event::SequenceStart(..) => Value::List(Vec::new()),
            Event::MappingStart(..) => Value::Map(Vec::new()),
            Event::SequenceEnd | Event::MappingEnd => {
                let (node, _) = open.pop().expect("the parser pairs starts and ends");
                node.check_keys()?;
                add_node(node, &mut open, &mut root);
                continue;
            }
            Event::DocumentStart(..) if documents == 1 => return refuse("more than one document"),
            Event::DocumentStart(..) => {
                documents += 1;
                continue;
            }
            _ => continue,
        };
        nodes += 1;
        if nodes > MAX_NODES {
            return refuse("too many values");
        }
        let is_scalar = matches!(value, Value::Scalar { .. });
        let node = Node { line, value };
        if is_scalar {
            add_node(node, &mut open, &mut root);
        } else if open.len() == MAX_DEPTH {
            return refuse("too deeply nested");
        } else {
            open.push((node, None));
        }
    }
    Ok(root.unwrap_or(Node {
        line: 1,
        value: Value::Scalar {
            text: String::new(),
            plain: true,
        },
    }))
}

/// Adds a finished node to the innermost open node. An open mapping also stores a key that has no value yet.
fn add_node(node: Node, open: &mut [(Node, Option<Node>)], root: &mut Option<Node>) {
    let Some((parent, waiting)) = open.last_mut() else {
        *root = Some(node);
        return;
    };
    match &mut parent.value {
        Value::List(items) => items.push(node),
        Value::Map(entries) => match waiting.take() {
            Some(key) => entries.push((key, node)),
            None => *waiting = Some(node),
        },
        Value::Scalar { .. } => unreachable!("a scalar has no children"),
    }
}

impl Node {
    /// Checks that all keys of a mapping are distinct scalars.
    fn check_keys(&self) -> Result<()> {
        let Value::Map(entries) = &self.value else {
            return Ok(());
        };
        let mut keys = HashSet::new();
        for (Node { line, value }, _) in entries {
            match value {
                Value::Scalar { text, .. } if keys.insert(text) => {}
                Value::Scalar { text, .. } => {
                    return Error::at_line(*line, format!("duplicate key {text}"));
                }
                _ => return Error::at_line(*line, "expected a key"),
            }
        }
        Ok(())
    }

    /// Interprets a scalar according to the core schema of YAML 1.2.
    fn interpret(&self) -> Unexpected<'_> {
        let (text, plain) = match &self.value {
            Value::List(_) => return Unexpected::Seq,
            Value::Map(_) => return Unexpected::Map,
            Value::Scalar { text, plain } => (text, *plain),
        };
        match text.as_str() {
            _ if !plain => Unexpected::Str(text),
            "" | "~" | "null" | "Null" | "NULL" => Unexpected::Unit,
            "true" | "True" | "TRUE" => Unexpected::Bool(true),
            "false" | "False" | "FALSE" => Unexpected::Bool(false),
            _ => parse_number(text).unwrap_or(Unexpected::Str(text)),
        }
    }

    fn type_error<'de>(&self, visitor: &impl Visitor<'de>) -> YamlError {
        de::Error::invalid_type(self.interpret(), visitor)
    }
}

fn parse_number(text: &str) -> Option<Unexpected<'_>> {
    let digits = text.trim_start_matches(['+', '-']);
    match digits {
        ".inf" | ".Inf" | ".INF" if text.starts_with('-') => {
            return Some(Unexpected::Float(f64::NEG_INFINITY));
        }
        ".inf" | ".Inf" | ".INF" => return Some(Unexpected::Float(f64::INFINITY)),
        ".nan" | ".NaN" | ".NAN" => return Some(Unexpected::Float(f64::NAN)),
        // Rust's parser also accepts words such as "infinity".
        _ if !digits.starts_with(|c: char| c == '.' || c.is_ascii_digit()) => return None,
        _ => {}
    }
    let unsigned = text.parse().map(Unexpected::Unsigned);
    let signed = || text.parse().map(Unexpected::Signed);
    let float = || text.parse().map(Unexpected::Float);
    unsigned.or_else(|_| signed()).or_else(|_| float()).ok()
}

/// Implements deserializer methods as functions of the node and the visitor. Adds the node's line to errors without a line.
macro_rules! read {
    ($($name:ident($($parameter:ident: $type:ty),*) = $read:expr;)*) => {$(
        fn $name<V: Visitor<'de>>(self, $($parameter: $type,)* visitor: V) -> Result<V::Value, YamlError> {
            let read: fn(&Node, V) -> Result<V::Value, YamlError> = $read;
            read(self, visitor).map_err(|type_error| match type_error.line {
                0 => YamlError { line: self.line, ..type_error },
                _ => type_error,
            })
        }
    )*};
}

impl<'de> Deserializer<'de> for &Node {
    type Error = YamlError;

    read! {
        deserialize_any() = |node, visitor| match (&node.value, node.interpret()) {
            (Value::List(_), _) => node.deserialize_seq(visitor),
            (Value::Map(_), _) => node.deserialize_map(visitor),
            (_, Unexpected::Unit) => visitor.visit_unit(),
            (_, Unexpected::Bool(value)) => visitor.visit_bool(value),
            (_, Unexpected::Unsigned(value)) => visitor.visit_u64(value),
            (_, Unexpected::Signed(value)) => visitor.visit_i64(value),
            (_, Unexpected::Float(value)) => visitor.visit_f64(value),
            (Value::Scalar { text, .. }, _) => visitor.visit_str(text),
        };
        // A string does not need quotation marks, even if it looks like a number.
        deserialize_str() = |node, visitor| match &node.value {
            Value::Scalar { plain: true, .. } if matches!(node.interpret(), Unexpected::Unit) => {
                Err(node.type_error(&visitor))
            }
            Value::Scalar { text, .. } => visitor.visit_str(text),
            _ => Err(node.type_error(&visitor)),
        };
        deserialize_string() = |node, visitor| node.deserialize_str(visitor);
        deserialize_identifier() = |node, visitor| node.deserialize_str(visitor);
        deserialize_option() = |node, visitor| match node.interpret() {
            Unexpected::Unit => visitor.visit_none(),
            _ => visitor.visit_some(node),
        };
        deserialize_struct(_name: &'static str, _fields: &'static [&'static str]) = |node, visitor| {
            node.deserialize_map(visitor)
        };
        // Calling only one method of the visitor avoids generating code for the others.
        deserialize_map() = |node, visitor| match &node.value {
            Value::Map(entries) => {
                let entries = entries.iter().map(|(key, value)| (key, value));
                visitor.visit_map(MapDeserializer::new(entries))
            }
            _ => Err(node.type_error(&visitor)),
        };
        deserialize_seq() = |node, visitor| match &node.value {
            Value::List(items) => visitor.visit_seq(SeqDeserializer::new(items.iter())),
            _ => Err(node.type_error(&visitor)),
        };
        deserialize_tuple(_length: usize) = |node, visitor| node.deserialize_seq(visitor);
        deserialize_enum(_name: &'static str, _variants: &'static [&'static str]) = |node, visitor| {
            match &node.value {
                Value::Scalar { text, .. } => visitor.visit_enum(text.as_str().into_deserializer()),
                Value::Map(entries) => {
                    let entries = entries.iter().map(|(key, value)| (key, value));
                    visitor.visit_enum(MapAccessDeserializer::new(MapDeserializer::new(entries)))
                }
                Value::List(_) => Err(node.type_error(&visitor)),
            }
        };
        deserialize_newtype_struct(_name: &'static str) = |node, visitor| {
            visitor.visit_newtype_struct(node)
        };
        deserialize_ignored_any() = |_, visitor| visitor.visit_unit();
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char bytes byte_buf unit unit_struct
        tuple_struct
    }
}

impl IntoDeserializer<'_, YamlError> for &Node {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Record {
        id: String,
        #[serde(default)]
        first: bool,
        size: Option<u8>,
        way: Option<Way>,
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Way {
        Up,
        Down,
    }

    const ERRORS: &str = r#"
- id: a↵- id: b↵  frist: true => line 3: unknown field `frist`, expected one of `id`, `first`, `size`, `way`
- id: a↵  first: yes => line 2: invalid type: string "yes", expected a boolean
- id: a↵  first: 'true' => line 2: invalid type: string "true", expected a boolean
- { id: a, size: 256 } => line 1: invalid value: integer `256`, expected u8
- id: a↵↵  way: sideways => line 3: unknown variant `sideways`, expected `up` or `down`
- id: a↵  id: b => line 2: duplicate key id
- first: true => line 1: missing field `id`
- id: => line 1: invalid type: unit value, expected a string
id: a => line 1: expected a list
- id: &a b↵- id: *a => line 1: anchors and aliases are not supported
- id: !b a => line 1: tags are not supported
- id: a↵---↵- id: b => line 2: more than one document
- [[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]] => line 1: too deeply nested
"#;

    #[test]
    fn every_error_names_its_line() {
        for row in ERRORS.trim().lines() {
            let (text, error) = row.split_once(" => ").expect("a text and its error");
            let text = text.replace('↵', "\n") + "\n";
            assert_eq!(records::<Record>(&text).unwrap_err().to_string(), error);
        }
    }

    #[test]
    fn quoted_and_plain_scalars_are_read_by_type() {
        let read: Vec<(usize, Record)> =
            records("- { id: 1.0, size: 255, way: down }\n- id: 'null'\n  first: true\n")
                .expect("it is well-formed");
        let plain = Record {
            id: "1.0".to_owned(),
            first: false,
            size: Some(255),
            way: Some(Way::Down),
        };
        let quoted = Record {
            id: "null".to_owned(),
            first: true,
            size: None,
            way: None,
        };
        assert_eq!(read, [(1, plain), (2, quoted)]);
        assert_eq!(records::<Record>("# nothing\n").expect("a list"), []);
    }

    #[test]
    fn scalars_follow_the_core_schema() {
        let value: serde_json::Value =
            from_yaml("[1, -1, 1.5, .5, 1e3, inf, '1', ~, true, True, yes, 1.2.3, 2x]")
                .expect("it is well-formed");
        let expected = serde_json::json!([
            1, -1, 1.5, 0.5, 1000.0, "inf", "1", null, true, true, "yes", "1.2.3", "2x"
        ]);
        assert_eq!(value, expected);
    }
}
