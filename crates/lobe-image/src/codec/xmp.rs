//! XMP of panoramas: properties by name, in the namespace `GPano`.
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

/// The longest value that is kept.
const LONGEST_VALUE: usize = 256;

/// Adds the properties in a packet of XMP; one that cannot be understood is noted.
pub(crate) fn add_packet(packet: &[u8], panorama: &mut Panorama, notes: &mut Vec<String>) {
    if !packet.windows(MARK.len()).any(|part| part == MARK) {
        return;
    }
    let text = String::from_utf8_lossy(packet);
    // Some writers end with a zero, or begin with the mark of a byte order.
    let text = text.trim_matches(|c: char| c == '\0' || c == '\u{feff}' || c.is_whitespace());
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let Ok(document) = Document::parse_with_options(text, options) else {
        notes.push("its XMP speaks of a panorama and cannot be understood; it is ignored".to_owned());
        return;
    };
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
        let deep = packet("", &format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000)));
        let _ = found(&deep);
        let entities = format!("<!DOCTYPE a [<!ENTITY b 'c'>]>{whole}");
        let (panorama, notes) = found(&entities);
        assert!(panorama.is_empty() && notes.len() == 1, "entities: {panorama:?}, {notes:?}");
    }
}
