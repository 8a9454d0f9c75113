#include "evaluate/census.hpp"

#include <antumbra/evaluate.hpp>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace antumbra {
namespace {

using Json = nlohmann::json;

// One slice of heights at a time: a cell is drawn where the slice cuts it, the one that sees most on top.
constexpr const char* kPage = R"page(<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">
<title>Cells</title>
<style>
:root{color-scheme:light dark;--ink:#22262a;--soft:#667;--line:#d5d8dc;--paper:#fbfaf7;--card:#fff}
@media(prefers-color-scheme:dark){:root{--ink:#e6e6e3;--soft:#9aa;--line:#3a4046;--paper:#17191c;--card:#1f2327}}
body{margin:0 auto;max-width:72rem;padding:1.5rem;font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper)}
h1{margin:0}p{color:var(--soft);max-width:46rem}canvas{width:100%;border:1px solid var(--line);border-radius:6px;background:var(--card)}
.scroll{overflow-x:auto}table{border-collapse:collapse;width:100%;background:var(--card);font-variant-numeric:tabular-nums}
td,th{padding:.35rem .6rem;border-bottom:1px solid var(--line);text-align:right;white-space:nowrap}td:first-child,th:first-child{text-align:left}
.facts{display:flex;flex-wrap:wrap;gap:1.5rem}.facts b{display:block;font-size:1.2rem}.facts span{color:var(--soft)}
.scale{height:.8rem;border-radius:4px}.ends{display:flex;justify-content:space-between;color:var(--soft)}input{width:100%}
</style>
<h1 id="title"></h1><p id="about"></p><div class="facts" id="facts"></div>
<h2>From above</h2><p>Each cell coloured by the objects that it sees; where several lie over one another at this height, as
leaves of different directions do, the one that sees most. Grey: inside matter or not baked, where everything is drawn.</p>
<label>Height <output id="height"></output><input id="slice" type="range" min="0" max="1000" value="300"></label>
<canvas id="map" role="img" aria-label="Cells from above, coloured by how much they see"></canvas>
<div class="scale" id="scale"></div><div class="ends"><span id="least"></span><span id="most"></span></div>
<p id="under" aria-live="polite">Point at a cell.</p>
<h2>Cells that see most</h2><div class="scroll"><table id="worst"></table></div>
<h2>Costliest objects</h2><p>Triangles times cells that see them: what to simplify or split first.</p>
<div class="scroll"><table id="objects"></table></div>
<script>
const data = /*DATA*/;
const by = id => document.getElementById(id);
by("title").textContent = data.title; by("about").textContent = data.about;
for (const [name, value] of data.facts) {
  const fact = document.createElement("div"), bold = document.createElement("b"), label = document.createElement("span");
  bold.textContent = value; label.textContent = name; fact.append(bold, label); by("facts").append(fact);
}
function table(id, head, rows) {
  for (const [i, row] of [head, ...rows].entries()) {
    const line = by(id).insertRow();
    for (const text of row) { const cell = document.createElement(i ? "td" : "th"); cell.textContent = text; line.append(cell); }
  }
}
table("worst", ["cell", "objects seen", "box"], data.worst);
table("objects", ["object", "cells that see it", "triangles", "triangles over all cells"], data.objects);
// A perceptually even ramp from dark blue over green to yellow.
const stops = [[68,1,84],[59,82,139],[33,145,140],[94,201,98],[253,231,37]];
function colour(share) {
  const at = Math.min(3.999, Math.max(0, share * 4)), i = Math.floor(at), f = at - i;
  return "rgb(" + stops[i].map((c, k) => Math.round(c + (stops[i + 1][k] - c) * f)).join(",") + ")";
}
by("scale").style.background = "linear-gradient(90deg," + [0, .25, .5, .75, 1].map(colour).join(",") + ")";
const [low, high] = data.bounds, seen = data.cells.filter(c => c[6] >= 0).map(c => c[6]);
const least = seen.length ? seen.reduce((a, b) => Math.min(a, b)) : 0, most = seen.length ? seen.reduce((a, b) => Math.max(a, b)) : 1;
by("least").textContent = least + " objects"; by("most").textContent = most + " objects";
const canvas = by("map"), pen = canvas.getContext("2d");
let shown = [], scale = 1;
function draw() {
  const y = low[1] + (high[1] - low[1]) * by("slice").value / 1000;
  by("height").textContent = y.toPrecision(4);
  const width = canvas.clientWidth * devicePixelRatio, size = [high[0] - low[0], high[2] - low[2]];
  scale = Math.min(width / size[0], 900 * devicePixelRatio / size[1]);
  canvas.width = width; canvas.height = Math.max(40, size[1] * scale);
  shown = data.cells.filter(c => c[1] <= y && c[4] >= y).sort((a, b) => a[6] - b[6]);
  for (const c of shown) {
    pen.fillStyle = c[6] < 0 ? "#8884" : colour((c[6] - least) / Math.max(1, most - least));
    pen.fillRect((c[0] - low[0]) * scale, (c[2] - low[2]) * scale, (c[3] - c[0]) * scale - 1, (c[5] - c[2]) * scale - 1);
  }
}
canvas.addEventListener("pointermove", event => {
  const x = low[0] + event.offsetX * devicePixelRatio / scale, z = low[2] + event.offsetY * devicePixelRatio / scale;
  const under = shown.filter(c => c[0] <= x && c[3] >= x && c[2] <= z && c[5] >= z).pop();
  by("under").textContent = under ? (under[6] < 0 ? "No viewpoint, or not baked: everything is drawn." :
    `Sees ${under[6]} of ${data.objectCount} objects.`) : "Outside of every cell: everything is drawn.";
});
by("slice").addEventListener("input", draw); addEventListener("resize", draw); draw();
</script></html>
)page";

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

std::string box_text(const Box3d& box) {
    auto point = [](const Vec3d& p) {
        char text[96];
        std::snprintf(text, sizeof text, "(%.5g, %.5g, %.5g)", p.x, p.y, p.z);
        return std::string(text);
    };
    return point(box.min) + " .. " + point(box.max);
}

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f", value);
    return text;
}

} // namespace

std::string census_page(const Pvs& pvs, const Census& census, const std::string& title) {
    Json data;
    data["title"] = title;
    data["objectCount"] = pvs.object_count();
    data["about"] = "What can be seen from each cell of a baked file. Guarantee: " +
                    describe_guarantee(pvs) + ", method: " + std::string(pvs.method()) + ".";
    data["facts"] = Json::array({{"objects", std::to_string(pvs.object_count())},
                                 {"cells baked", std::to_string(census.baked)},
                                 {"inside matter", std::to_string(census.solid)},
                                 {"not baked", std::to_string(census.not_baked)},
                                 {"objects seen from a cell", number(census.mean_visible)},
                                 {"triangles seen from a cell", number(census.mean_visible_triangles)},
                                 {"bytes", std::to_string(pvs.file_bytes())}});
    Box3d bounds;
    data["cells"] = Json::array();
    for (const CensusCell& cell : census.cells) {
        bounds.extend(cell.box);
        data["cells"].push_back({rounded(cell.box.min.x), rounded(cell.box.min.y), rounded(cell.box.min.z),
                                 rounded(cell.box.max.x), rounded(cell.box.max.y), rounded(cell.box.max.z),
                                 cell.baked() ? std::int64_t(cell.visible) : -1});
    }
    data["bounds"] = {{bounds.min.x, bounds.min.y, bounds.min.z}, {bounds.max.x, bounds.max.y, bounds.max.z}};
    data["worst"] = Json::array();
    for (const CensusCell& cell : census.worst(10))
        data["worst"].push_back({std::to_string(cell.index), std::to_string(cell.visible), box_text(cell.box)});
    data["objects"] = Json::array();
    for (const CensusObject& object : costliest_objects(pvs, census, 10))
        data["objects"].push_back({std::string(pvs.object_name(object.object)), std::to_string(object.cells),
                                   std::to_string(pvs.object(object.object).triangle_count),
                                   std::to_string(object.cost)});
    std::string text = data.dump(-1, ' ', true, Json::error_handler_t::replace);
    // A name may hold "</script>"; escaped slashes and angles are the same JSON.
    std::string escaped;
    for (char c : text)
        escaped += c == '<' ? std::string("\\u003c") : std::string(1, c);
    std::string page = kPage;
    const std::string mark = "/*DATA*/";
    page.replace(page.find(mark), mark.size(), escaped);
    return page;
}

} // namespace antumbra
