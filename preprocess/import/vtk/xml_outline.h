#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray::preprocess {

/// An element of an XML text with everything in it. Views look into the text.
struct XmlElement {
  std::string_view name;
  std::map<std::string, std::string, std::less<>> attributes;  ///< entities replaced
  /// from the end of its tag to the next one: all of it where there are no elements inside
  std::string_view content;
  std::vector<XmlElement> children;

  /// Empty when it is not there.
  std::string_view attribute(std::string_view name) const;
  /// The first of that name; null when there is none.
  const XmlElement* child(std::string_view name) const;
};

/// The root element of a text in which no element `last` has been opened, or up to there: what
/// follows its tag is that element's content, to the end of the text, and is not looked at. Nothing
/// for what is not well-formed, or uses features that data files do not (document types, CDATA,
/// entities of their own).
std::optional<XmlElement> xml_outline(std::string_view text, std::string_view last);

}  // namespace rhoray::preprocess
