#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray::preprocess {

/// An XML element with its content. Views refer to the text.
struct XmlElement {
  std::string_view name;
  std::map<std::string, std::string, std::less<>> attributes;  ///< with entities replaced
  /// from the end of its tag to the next tag, without comments: all of it if there are no child
  /// elements
  std::string_view content;
  std::shared_ptr<const std::string> joined;  ///< holds the content where a comment interrupts it
  std::vector<XmlElement> children;

  /// Value of an attribute; empty if it is missing.
  std::string_view attribute(std::string_view name) const;
  /// The first child of that name; null when there is none.
  const XmlElement* child(std::string_view name) const;
};

/// Replaces numbers of characters, `&lt;` and the other four predefined entities; nothing if there
/// is any other.
std::optional<std::string> without_entities(std::string_view text);

/// The root element of a text, parsed up to the start of an element named `last`, if there is one.
/// The content of that element then runs to the end of the text and is not parsed. Nothing for text
/// that is not well-formed, or uses features that data files do not (declarations, CDATA).
/// @param end  receives the byte at which parsing ended
std::optional<XmlElement> xml_outline(std::string_view text, std::string_view last, std::size_t& end);

}  // namespace rhoray::preprocess
