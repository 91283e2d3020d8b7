#include "tools/analysis/html.h"

#include <cstdint>
#include <regex>

#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

constexpr const char* style = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 'Helvetica Neue', Helvetica, Arial, sans-serif; color: #1b1b1b; background: #fff;
  max-width: 1160px; margin: 2.5rem auto; padding: 0 1.5rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; font-weight: 600; }
h2 { font-size: 1.4rem; margin: 2.6rem 0 .6rem; padding-bottom: .25rem; border-bottom: 1px solid #ccc; font-weight: 600; }
h2::first-letter { text-transform: uppercase; }
h3 { font-size: 1.1rem; margin: 2rem 0 .4rem; font-weight: 600; }
p, li { max-width: 52rem; }
.lead { color: #555; margin-top: 0; }
.stage { background: #fff7d6; border-left: 4px solid #ccbb44; padding: .5rem .9rem; }
.found li { margin: .35rem 0; }
code { font: .92em ui-monospace, 'DejaVu Sans Mono', Menlo, monospace; background: #f3f3f3; padding: 0 .2em; }
pre { font: .85rem/1.45 ui-monospace, 'DejaVu Sans Mono', Menlo, monospace; background: #f6f6f6; padding: .8rem 1rem;
  white-space: pre-wrap; overflow-wrap: anywhere; }
sup { line-height: 0; font-size: .75em; }
table { border-collapse: collapse; font-size: .8rem; line-height: 1.35; font-variant-numeric: tabular-nums; }
.wide table { width: 100%; }
th, td { text-align: right; padding: .22rem .5rem; border-bottom: 1px solid #e6e6e6; vertical-align: top; }
th { font-weight: 600; border-bottom: 2px solid #999; vertical-align: bottom; }
th:first-child, td:first-child, .words td, .words th { text-align: left; }
th[colspan] { text-align: center; border-bottom: 1px solid #ccc; }
th small { font-weight: 400; color: #666; }
td small { color: #666; }
.words td:first-child { white-space: nowrap; padding-right: 1.5rem; }
tr.group td { background: #f3f5f8; font-weight: 600; text-align: left; }
tr.front td:first-child { font-weight: 600; }
.wide td.left { color: #777; text-align: left; white-space: normal; }
.wide { overflow-x: auto; }
.wide td { white-space: nowrap; }
figure { margin: 1rem 0 1.8rem; }
figure svg, figure img { max-width: 100%; height: auto; }
figcaption { color: #444; font-size: .9rem; max-width: 52rem; }
.legend { font-size: .9rem; max-width: none; }
.legend .bar { display: inline-block; width: 14rem; height: .9rem; vertical-align: -.1rem; }
.legend .square { display: inline-block; width: .9rem; height: .9rem; vertical-align: -.1rem; border: 1px solid #bbb;
  margin-left: .6rem; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(520px, 1fr)); gap: 1.2rem 1.4rem; }
.pictures figure { margin: 0; }
.pictures .pair { display: grid; grid-template-columns: 1fr 1fr; gap: 4px; align-items: start; }
.pictures img { border: 1px solid #ddd; width: 100%; box-sizing: border-box; }
details summary { cursor: pointer; font-weight: 600; margin: 2rem 0 .4rem; }
@media print { body { margin: 0; max-width: none; font-size: 11px; } figure, tr { break-inside: avoid; }
  h2, h3 { break-after: avoid; } }
)";

}  // namespace

std::string html_text(std::string_view text) {
  std::string out;
  bool is_code = false;
  for (const char letter : text) switch (letter) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '`':
        out += is_code ? "</code>" : "<code>";
        is_code = !is_code;
        break;
      default:
        out += letter;
    }
  return is_code ? out + "</code>" : out;
}

std::string with_powers(std::string_view html) {
  static const std::regex code_or_number("<code>[^<]*</code>|<[^>]*>|([0-9]+(?:\\.[0-9]+)?)e([+-])0*([0-9]+)");
  std::string out;
  std::size_t at = 0;
  for (std::cregex_iterator found(html.data(), html.data() + html.size(), code_or_number), end; found != end; ++found) {
    const std::cmatch& match = *found;
    out += html.substr(at, static_cast<std::size_t>(match.position()) - at);
    at = static_cast<std::size_t>(match.position() + match.length());
    if (!match[1].matched) {
      out += match.str();
      continue;
    }
    if (match[1] != "1") out += concat(match[1].str(), " × ");
    out += concat("10<sup>", match[2] == "-" ? "−" : "", match[3].str(), "</sup>");
  }
  return out.append(html.substr(at));
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 3; ++i) word = word << 8 | (i < count ? static_cast<std::uint8_t>(bytes[at + i]) : 0U);
    for (std::size_t i = 0; i < 4; ++i) out += i <= count ? letters[word >> (18 - 6 * i) & 63] : '=';
  }
  return out;
}

std::string html_page(const std::string& title, const std::string& body) {
  return concat("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n",
                "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
                "'unsafe-inline'\">\n",
                "<meta name=\"viewport\" content=\"width=device-width\">\n<title>", html_text(title),
                "</title>\n<style>", style, "</style>\n</head>\n<body>\n", body, "</body>\n</html>\n");
}

}  // namespace rhoray::tools
