#include "vdbpack/report/page_frame.h"

#include "vdbpack/io/text.h"
#include "vdbpack/report/markup.h"
#include "vdbpack/report/report.h"

#include <fmt/format.h>

namespace vdbpack {

namespace {

const char* const kStyle = R"(:root { color-scheme: light dark; --paper: #f5f6f8; --card: #fff;
  --ink: #16202b; --soft: #536070; --line: #dfe3e8; --c0: #2f74b5; --c1: #c2560c;
  --good: #1d7a46; --bad: #b3261e; }
@media (prefers-color-scheme: dark) { :root { --paper: #11161c; --card: #1a212a; --ink: #e8ecf1;
  --soft: #a3afbd; --line: #333d49; --c0: #5ba3e6; --c1: #f29a52; --good: #5cc98a; --bad: #ff8a80; } }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 1rem/1.45 system-ui, sans-serif; overflow-wrap: anywhere; }
main { max-width: 78rem; margin: 0 auto; padding: 1rem .75rem 3rem; }
h1 { font-size: 1.5rem; line-height: 1.2; margin: .5rem 0 .2rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .6rem; }
h3 { font-size: 1rem; margin: 0 0 .4rem; }
h4 { font-size: .875rem; margin: .6rem 0 .2rem; }
p { margin: .3rem 0; }
.under, .words, .none { color: var(--soft); }
.words { font-size: .8125rem; }
.picture { margin: 1rem 0 0; }
.picture img { display: block; width: 100%; max-width: 60rem; height: auto; margin: 0 auto .4rem;
  background: #fff; border-radius: .3rem; }
.keys { display: grid; grid-template-columns: repeat(auto-fit, minmax(10rem, 1fr)); gap: .6rem;
  margin: 1rem 0 0; }
.keys div, figure, section, .card { background: var(--card); border: 1px solid var(--line);
  border-radius: .5rem; padding: .6rem .75rem; }
.keys dt { font-size: .8125rem; color: var(--soft); }
.keys dd { margin: 0; font-size: 1.3rem; font-weight: 600; line-height: 1.3; }
.keys dd + dd { font-size: .8125rem; font-weight: 400; color: var(--soft); }
.keys .hash { font-size: .8125rem; line-height: 1.9; font-family: ui-monospace, monospace; }
.good { color: var(--good); }
.bad { color: var(--bad); }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 21rem), 1fr));
  gap: .6rem; }
.tables { columns: 24rem; column-gap: .6rem; }
.tables section { break-inside: avoid; margin: 0 0 .6rem; }
table { width: 100%; border-collapse: collapse; font-size: .875rem;
  font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .15rem .5rem .15rem 0; font-weight: 400;
  border-top: 1px solid var(--line); }
tbody th { color: var(--soft); width: 45%; }
.columns th, .columns td { text-align: right; width: auto; white-space: nowrap; }
.scroll { overflow-x: auto; max-height: 26rem; overflow-y: auto; }
summary { cursor: pointer; font-size: .875rem; margin-top: .4rem; }
pre { margin: .4rem 0; white-space: pre-wrap; font: .875rem/1.4 ui-monospace, monospace;
  background: var(--paper); border-radius: .3rem; padding: .5rem; }
.card table { width: auto; }
.card th { width: auto; padding-right: 2rem; white-space: nowrap; }
ul { margin: .3rem 0; padding-left: 1.2rem; }
@media print { :root { color-scheme: light; --paper: #fff; --card: #fff; --ink: #000; --soft: #444;
  --line: #bbb; --c0: #2f74b5; --c1: #c2560c; --good: #1d7a46; --bad: #b3261e; }
  main { padding: 0; max-width: none; } figure, .keys div { break-inside: avoid; }
  .charts { grid-template-columns: 1fr 1fr; } .tables { columns: 2; }
  .tables section { break-inside: auto; } .scroll { max-height: none; overflow: visible; }
  .columns { font-size: .6875rem; }
  details::details-content { content-visibility: visible; display: block; } }
)";

}  // namespace

std::string pictureFigure(const PagePicture& picture) {
    if (picture.png.empty() && picture.view.empty()) return {};
    std::string out = "<figure class='picture'>\n";
    // The last clause, the rows of the scene, is for programs.
    const std::string words = escaped(picture.words.substr(0, picture.words.rfind("; scene ")));
    if (!picture.png.empty())
        out +=
            fmt::format("<img src='data:image/png;base64,{}' width='{}' height='{}' alt='{}'/>\n",
                        base64(picture.png), picture.width, picture.height, words);
    // The caption is of the picture; a view has its own words.
    if (!picture.png.empty())
        out += fmt::format("<figcaption class='words'>{}</figcaption>\n", words);
    return out + picture.view + "</figure>\n";
}

std::string htmlPage(const std::string& title, const std::string& style, const std::string& main) {
    return "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'/>\n"
           "<meta name='viewport' content='width=device-width, initial-scale=1'/>\n"
           "<link rel='icon' href='data:,'/>\n<title>" +
           escaped(title) + "</title>\n<style>\n" + kStyle + style +
           "</style>\n</head>\n<body>\n<main>\n" + main + "</main>\n</body>\n</html>\n";
}

bool isPage(const std::string& reportFile) {
    return extensionOf(reportFile) == ".html";
}

}  // namespace vdbpack
