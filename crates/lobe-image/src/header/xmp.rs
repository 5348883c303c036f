//! XMP of a panorama: properties by name, in the namespace `GPano`.
//!
//! ```text
//!   <rdf:Description GPano:ProjectionType="equirectangular" .../>          as attributes
//!   <GPano:ProjectionType>equirectangular</GPano:ProjectionType>           as elements
//! ```
//!
//! Cameras and stitchers write them; the names are those of [Google 2013]. The values stay text: what they mean for
//! directions is up to the caller.

use std::collections::BTreeMap;

use roxmltree::{Document, ParsingOptions};

/// The properties of a panorama by their names, `ProjectionType` and others.
pub(crate) type Panorama = BTreeMap<String, String>;

/// The namespace of the properties.
const NAMESPACE: &str = "http://ns.google.com/photos/1.0/panorama/";

/// The part of the namespace that is looked for before XML is parsed: most packets hold nothing of it.
const MARK: &[u8] = b"ns.google.com/photos/1.0/panorama";

/// The most elements, attributes and texts of a packet, far above any that describes a picture.
const MOST_NODES: u32 = 1 << 18;

/// The most attributes of an element.
const MOST_ATTRIBUTES: usize = 1 << 12;

/// The most declarations of namespaces; packets have some ten to forty.
const MOST_NAMESPACES: usize = 1 << 8;

/// The longest value that is kept.
const LONGEST_VALUE: usize = 256;

/// Calls `look` with the document of a packet of XMP; none if it cannot be understood.
pub(crate) fn with_document<T>(packet: &[u8], look: impl FnOnce(&Document<'_>) -> T) -> Option<T> {
    let text = String::from_utf8_lossy(packet);
    // Some writers end with a zero, or begin with the mark of a byte order.
    let text = text.trim_matches(|c: char| c == '\0' || c == '\u{feff}' || c.is_whitespace());
    // The parser compares each attribute of an element with all before it, and each element copies the namespaces
    // around it. No value of an attribute has a `<` in it.
    let attributes = text.split('<').map(|part| part.bytes().filter(|byte| *byte == b'=').count()).max();
    let namespaces = text.matches("xmlns").count();
    if attributes > Some(MOST_ATTRIBUTES) || namespaces > MOST_NAMESPACES {
        return None;
    }
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Some(look(&Document::parse_with_options(text, options).ok()?))
}

/// Adds the properties in a packet of XMP; one that cannot be understood is noted.
pub(crate) fn add_packet(packet: &[u8], panorama: &mut Panorama, notes: &mut Vec<String>) {
    if !packet.windows(MARK.len()).any(|part| part == MARK) {
        return;
    }
    if with_document(packet, |document| add_properties(document, panorama)).is_none() {
        notes.push("its XMP speaks of a panorama and cannot be understood; it is ignored".to_owned());
    }
}

fn add_properties(document: &Document<'_>, panorama: &mut Panorama) {
    for element in document.descendants().filter(roxmltree::Node::is_element) {
        for attribute in element.attributes().filter(|attribute| attribute.namespace() == Some(NAMESPACE)) {
            add(attribute.name(), attribute.value(), panorama);
        }
        if element.tag_name().namespace() == Some(NAMESPACE)
            && let Some(value) = element.text()
        {
            add(element.tag_name().name(), value, panorama);
        }
    }
}

/// Adds a property; the first of a name holds.
pub(crate) fn add(name: &str, value: &str, panorama: &mut Panorama) {
    let value: String = value.trim().chars().filter(|c| !c.is_control()).take(LONGEST_VALUE).collect();
    if !value.is_empty() {
        panorama.entry(name.to_owned()).or_insert(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(packet: &str) -> (Panorama, Vec<String>) {
        let (mut panorama, mut notes) = (Panorama::new(), Vec::new());
        add_packet(packet.as_bytes(), &mut panorama, &mut notes);
        (panorama, notes)
    }

    /// A packet around a description with these attributes and elements.
    pub(crate) fn packet(attributes: &str, elements: &str) -> String {
        format!(
            "<?xpacket begin='\u{feff}' id='W5M0MpCehiHzreSzNTczkc9d'?><x:xmpmeta xmlns:x='adobe:ns:meta/'>\
             <rdf:RDF xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'>\
             <rdf:Description rdf:about='' xmlns:GPano='{NAMESPACE}' {attributes}>{elements}</rdf:Description>\
             </rdf:RDF></x:xmpmeta><?xpacket end='w'?>\n\n   \0"
        )
    }

    #[test]
    fn properties_are_found_as_attributes_as_elements_and_by_any_prefix() {
        let attributes = packet("GPano:ProjectionType='equirectangular' GPano:CroppedAreaTopPixels=' 7 '", "");
        let elements = packet(
            "",
            "<GPano:ProjectionType>equirectangular</GPano:ProjectionType>\
             <GPano:CroppedAreaTopPixels>\n7\n</GPano:CroppedAreaTopPixels>",
        );
        for packet in [attributes.replace("GPano:", "pano:").replace(":GPano", ":pano"), attributes, elements] {
            let (panorama, notes) = found(&packet);
            let found: Vec<_> = panorama.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
            assert_eq!(found, [("CroppedAreaTopPixels", "7"), ("ProjectionType", "equirectangular")], "{packet}");
            assert!(notes.is_empty(), "{packet}: {notes:?}");
        }
    }

    #[test]
    fn packets_of_other_things_say_nothing_and_broken_ones_are_noted() {
        assert_eq!(found("<x:xmpmeta xmlns:x='adobe:ns:meta/'/>"), (Panorama::new(), Vec::new()), "nothing of it");
        assert_eq!(found("no XML"), (Panorama::new(), Vec::new()), "another text");
        let whole = packet("GPano:ProjectionType='equirectangular'", "");
        let (panorama, notes) = found(&whole[..whole.len() - 60]);
        assert!(panorama.is_empty() && notes.len() == 1, "cut off: {panorama:?}, {notes:?}");
        let many: String = (0..2 * MOST_ATTRIBUTES).map(|k| format!(" a{k}=''")).collect();
        assert_eq!(found(&packet(&many, "")).1.len(), 1, "more attributes than are compared in a moment");
        let ends = many.replace("''", "'>'");
        assert_eq!(found(&packet(&ends, "")).1.len(), 1, "attributes that seem to end their element");
        let spaces: String = (0..2 * MOST_NAMESPACES).map(|k| format!(" xmlns:a{k}='u'")).collect();
        assert_eq!(found(&packet(&spaces, "")).1.len(), 1, "more namespaces than are compared in a moment");
        let deep = packet("", &format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000)));
        let _ = found(&deep);
        let entities = format!("<!DOCTYPE a [<!ENTITY b 'c'>]>{whole}");
        let (panorama, notes) = found(&entities);
        assert!(panorama.is_empty() && notes.len() == 1, "entities: {panorama:?}, {notes:?}");
    }
}
