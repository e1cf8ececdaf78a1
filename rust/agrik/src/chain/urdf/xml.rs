//! From text to the few elements a chain needs.
//!
//! A pull parser rather than a document tree: it accepts undeclared prefixes
//! (`<sensor:camera>`), which old exporters write and tree parsers refuse, and its memory
//! does not grow with the meshes and sensors of a file.

use std::borrow::Cow;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::text::quoted;
use super::{fault, limits};
use crate::error::Result;

/// One element with its attributes.
#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    /// Line of the text it starts on, from 1.
    pub line: usize,
    attributes: Vec<(String, String)>,
    /// Those of `<robot>` and `<joint>` only.
    pub children: Vec<Element>,
}

impl Element {
    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// The first child of that name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }
}

/// The `<robot>` element.
pub(super) fn read(text: &str) -> Result<Element> {
    let text = text.trim_start_matches('\u{feff}');
    if text.trim().is_empty() {
        return Err(fault("the text is empty"));
    }
    if text.len() > limits::TEXT {
        let (most, size) = (limits::TEXT, text.len());
        return Err(fault(format!("a text of {size} bytes, expected at most {most}")));
    }
    let mut reader = Reader::from_str(text);
    reader.config_mut().expand_empty_elements = true;
    let mut lines = Lines { text, position: 0, line: 1 };
    let mut root = None;
    let mut open: Vec<Element> = Vec::new();
    // How many elements deep the reader is inside one that is passed over.
    let mut skipped = 0_usize;
    loop {
        let start = position(reader.buffer_position());
        let event = reader.read_event().map_err(|error| {
            let line = lines.at(position(reader.error_position()));
            fault(format!("not well-formed XML at line {line}: {error}"))
        })?;
        match event {
            Event::Start(_) if skipped > 0 || is_passed_over(&open) => skipped += 1,
            Event::Start(tag) => {
                let line = lines.at(start);
                if root.is_some() {
                    return Err(fault(format!("line {line}: a second root element")));
                }
                let element = element(&tag, line)?;
                if open.is_empty() && element.name != "robot" {
                    let name = &element.name;
                    return Err(fault(format!("the root element is <{name}>, not <robot>")));
                }
                open.push(element);
            }
            Event::End(_) if skipped > 0 => skipped -= 1,
            Event::End(_) => {
                if let Some(element) = open.pop() {
                    match open.last_mut() {
                        Some(parent) => parent.children.push(element),
                        None => root = Some(element),
                    }
                }
            }
            Event::Eof => break,
            _ => {}
        }
    }
    if let Some(element) = open.last() {
        let (name, line) = (&element.name, element.line);
        return Err(fault(format!("the text ends inside <{name}>, which starts on line {line}")));
    }
    root.ok_or_else(|| {
        let start: String = text.trim().chars().take(40).collect();
        fault(format!("not XML: no <robot> element in a text that starts with {}", quoted(&start)))
    })
}

/// True where the elements inside the innermost open one do not matter.
fn is_passed_over(open: &[Element]) -> bool {
    open.last().is_some_and(|e| open.len() > 2 || (open.len() == 2 && e.name != "joint"))
}

fn element(tag: &BytesStart<'_>, line: usize) -> Result<Element> {
    let refuse = |error: &dyn std::fmt::Display| {
        fault(format!("not well-formed XML at line {line}: {error}"))
    };
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|e| refuse(&e))?;
        // The parser compares each key with all before it.
        if attributes.len() == limits::ATTRIBUTES {
            let most = limits::ATTRIBUTES;
            return Err(fault(format!("line {line}: an element of more than {most} attributes")));
        }
        let value = attribute
            .normalized_value(XmlVersion::Implicit1_0)
            .map(Cow::into_owned)
            .map_err(|e| refuse(&e))?;
        attributes.push((attribute.key.as_ref().to_string(), value));
    }
    let name = tag.name().as_ref().to_string();
    Ok(Element { name, line, attributes, children: Vec::new() })
}

fn position(offset: u64) -> usize {
    usize::try_from(offset).unwrap_or(usize::MAX)
}

/// Line numbers of growing positions, counted once.
struct Lines<'a> {
    text: &'a str,
    position: usize,
    line: usize,
}

impl Lines<'_> {
    fn at(&mut self, position: usize) -> usize {
        let position = position.min(self.text.len());
        if position > self.position {
            let passed = &self.text.as_bytes()[self.position..position];
            self.line += passed.iter().filter(|&&byte| byte == b'\n').count();
            self.position = position;
        }
        self.line
    }
}
