// Uniting the parts of a sharded bake. A part is a whole .pvs file in which the units of other shards are not baked.
#include "bake/parts.hpp"

#include <algorithm>
#include <map>

namespace antumbra {
namespace {

using Json = nlohmann::ordered_json;

/// Numbers of `counts` onto those of `sum`, also within objects; of numbers whose name begins with "most_" the greater
/// one. False if their keys differ.
bool add_counts(Json& sum, const Json& counts, const std::string& name = "") {
    if (sum.is_number_unsigned() && counts.is_number_unsigned()) {
        auto a = sum.get<std::uint64_t>(), b = counts.get<std::uint64_t>();
        sum = name.starts_with("most_") ? std::max(a, b) : a + b;
        return true;
    }
    if (!sum.is_object() || !counts.is_object() || sum.size() != counts.size())
        return sum == counts;
    for (auto& [key, value] : sum.items())
        if (!counts.contains(key) || !add_counts(value, counts[key], key))
            return false;
    return true;
}

/// False if the text describes no part.
bool parse(std::string_view text, PartDescription& part) {
    Json json = Json::parse(text, nullptr, false);
    if (!json.is_object() || !json.contains("shard") || !json.contains("options") || !json.contains("counts"))
        return false;
    const Json& shard = json["shard"];
    if (!shard.is_object() || !shard.contains("index") || !shard.contains("count") ||
        !shard.contains("plan") || !shard["plan"].is_number_unsigned() || !shard["index"].is_number_unsigned() || !shard["count"].is_number_unsigned())
        return false;
    part.shard = {shard["index"].get<std::uint32_t>() - 1, shard["count"].get<std::uint32_t>()};
    part.plan = shard["plan"].get<std::uint64_t>();
    part.options = json["options"];
    part.counts = json["counts"];
    return part.shard.index < part.shard.count;
}

class Merger {
  public:
    Merger(std::span<const Pvs> parts, std::span<const std::string> names) : parts_(parts), names_(names) {}

    Status check();
    Result<PvsData> merge();

  private:
    /// A place where an answer stands: row `row` of a part, or a special value.
    struct Answer {
        std::size_t part = 0;
        std::uint32_t row = kCellNotBaked;
    };

    std::string name(std::size_t part) const { return part < names_.size() ? names_[part] : std::to_string(part + 1); }
    Status mismatch(std::size_t part, const std::string& text) const {
        return Status(ErrorCode::mismatch, text).in(name(part));
    }
    std::string head(const Pvs& pvs) const;
    void begin(PvsData& data) const;
    std::uint32_t row_of(const Answer& answer, PvsData& data);
    Status merge_cells(PvsData& data);
    Status merge_nodes(std::vector<std::pair<std::size_t, std::uint32_t>> at, PvsData& data);

    std::span<const Pvs> parts_;
    std::span<const std::string> names_;
    std::vector<PartDescription> described_;
    std::map<std::vector<std::uint64_t>, std::uint32_t> rows_;
};

/// Everything that all parts must have in common, as bytes: the file without cells and rows.
std::string Merger::head(const Pvs& pvs) const {
    std::string text(pvs.method());
    text += '\0';
    text += pvs.tool_version();
    text += '\0';
    auto add = [&](const auto& value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
    add(pvs.scene_fingerprint());
    add(pvs.structure_fingerprint());
    add(pvs.sides());
    for (const CellGrid& grid : {pvs.grid(), pvs.volumes()}) {
        add(grid.bounds);
        add(grid.count);
    }
    add(pvs.tree().bounds);
    for (std::uint32_t o = 0; o < pvs.object_count(); ++o) {
        PvsObject object = pvs.object(o);
        add(object.node);
        add(object.primitive);
        add(object.instance);
        add(object.flags);
        add(object.triangle_count);
        add(object.bounds);
        text += object.name;
        text += '\0';
    }
    return text;
}

Status Merger::check() {
    if (parts_.empty())
        return {ErrorCode::usage, "there are no parts to merge"};
    std::string first = head(parts_[0]);
    std::map<std::uint32_t, std::size_t> shards;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        PartDescription part;
        if (!parse(parts_[p].options_json(), part))
            return mismatch(p, "is no part of a sharded bake; bake it with --shard I/N");
        if (p > 0 && (part.shard.count != described_[0].shard.count || part.plan != described_[0].plan || part.options != described_[0].options ||
                      head(parts_[p]) != first))
            return mismatch(p, "belongs to another bake than " + name(0) +
                                   " (other scene, options, --where, version or number of shards)");
        auto [known, fresh] = shards.emplace(part.shard.index, p);
        if (!fresh)
            return mismatch(p, "is shard " + std::to_string(part.shard.index + 1) + " of " +
                                   std::to_string(part.shard.count) + ", as is " + name(known->second) +
                                   "; give each part once");
        described_.push_back(std::move(part));
    }
    std::string missing;
    for (std::uint32_t s = 0, told = 0; s < described_[0].shard.count && told < 8; ++s)
        if (!shards.contains(s)) {
            missing += (told++ ? ", " : "") + std::to_string(s + 1);
        }
    if (!missing.empty())
        return {ErrorCode::mismatch, "of " + std::to_string(described_[0].shard.count) + " parts these are missing: " +
                                         missing + "; bake them with --shard I/" +
                                         std::to_string(described_[0].shard.count)};
    return {};
}

/// Of an object: more are only claimed by a damaged file, which is refused when the result is written.
constexpr std::uint32_t kMostTriangles = 1u << 28;

void Merger::begin(PvsData& data) const {
    const Pvs& one = parts_[0];
    data.guarantee = one.guarantee();
    for (const Pvs& part : parts_) // exact parts and parts with an exhausted budget: as if baked in one
        if (part.guarantee() != data.guarantee)
            data.guarantee = Guarantee::conservative;
    data.method = one.method();
    data.tool_version = one.tool_version();
    data.scene_fingerprint = one.scene_fingerprint();
    data.structure_fingerprint = one.structure_fingerprint();
    data.sides = one.sides();
    data.origin = one.origin();
    data.grid = one.grid();
    data.volumes = one.volumes();
    for (std::uint32_t c = 0; one.cluster_count() > 0 && c <= one.cluster_count(); ++c)
        data.cluster_first.push_back(one.cluster_first(c));
    for (std::uint32_t o = 0; one.tells_triangles() && o < one.object_count(); ++o)
        data.triangles.push_back(one.triangles_of(o, kMostTriangles));
    data.tree.bounds = one.tree().bounds;
    for (std::uint32_t o = 0; o < one.object_count(); ++o)
        data.objects.push_back(one.object(o));
}

/// Numbers distinct rows in the order in which they are first needed, as bake() does.
std::uint32_t Merger::row_of(const Answer& answer, PvsData& data) {
    if (answer.row >= kCellSolid)
        return answer.row;
    std::vector<std::uint64_t> row(data.words_per_row());
    parts_[answer.part].decode_row(answer.row, row);
    auto [known, fresh] = rows_.try_emplace(std::move(row), data.row_count);
    if (fresh) {
        data.rows.insert(data.rows.end(), known->first.begin(), known->first.end());
        ++data.row_count;
    }
    return known->second;
}

Status Merger::merge_cells(PvsData& data) {
    for (std::uint64_t cell = 0; cell < data.grid.cells(); ++cell) {
        Answer answer;
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            std::uint32_t row = parts_[p].cell_row(cell);
            if (row == kCellNotBaked)
                continue;
            if (answer.row != kCellNotBaked)
                return mismatch(p, "overlaps " + name(answer.part) + " in cell " + std::to_string(cell));
            answer = {p, row};
        }
        data.cell_row.push_back(row_of(answer, data));
    }
    return {};
}

/// `at`: the node at this place of each part whose tree goes down to it.
Status Merger::merge_nodes(std::vector<std::pair<std::size_t, std::uint32_t>> at, PvsData& data) {
    std::erase_if(at, [&](const auto& place) {
        const ViewNode& node = parts_[place.first].tree().nodes[place.second];
        return node.axis == ViewNode::kLeaf && node.link == kCellNotBaked;
    });
    if (at.empty()) {
        data.tree.nodes.push_back({ViewNode::kLeaf, 0, kCellNotBaked});
        return {};
    }
    auto node_at = [&](std::size_t k) { return parts_[at[k].first].tree().nodes[at[k].second]; };
    ViewNode node = node_at(0);
    for (std::size_t k = 1; k < at.size(); ++k)
        if (node_at(k).axis != node.axis || node_at(k).split != node.split || node.axis == ViewNode::kLeaf)
            return mismatch(at[k].first, "overlaps " + name(at[0].first));
    if (node.axis == ViewNode::kLeaf) {
        data.tree.nodes.push_back({ViewNode::kLeaf, 0, row_of({at[0].first, node.link}, data)});
        return {};
    }
    std::size_t index = data.tree.nodes.size();
    data.tree.nodes.push_back(node);
    auto children = at;
    for (auto& child : children)
        ++child.second;
    if (Status status = merge_nodes(std::move(children), data); !status)
        return status;
    data.tree.nodes[index].link = std::uint32_t(data.tree.nodes.size());
    for (auto& child : at)
        child.second = parts_[child.first].tree().nodes[child.second].link;
    return merge_nodes(std::move(at), data);
}

Result<PvsData> Merger::merge() {
    PvsData data;
    begin(data);
    PartDescription whole{{}, 0, described_[0].options, described_[0].counts};
    for (std::size_t p = 1; p < parts_.size(); ++p)
        if (!add_counts(whole.counts, described_[p].counts))
            return mismatch(p, "counts other things than " + name(0));
    data.options_json = describe_part(whole);
    Status status;
    if (parts_[0].tree().nodes.empty()) {
        status = merge_cells(data);
    } else {
        std::vector<std::pair<std::size_t, std::uint32_t>> roots;
        for (std::size_t p = 0; p < parts_.size(); ++p)
            roots.push_back({p, 0});
        status = merge_nodes(std::move(roots), data);
    }
    if (!status)
        return status;
    return data;
}

} // namespace

std::string describe_part(const PartDescription& part) {
    Json json;
    if (part.shard.count == 1) {
        json = part.options;
        json.update(part.counts);
    } else {
        json["shard"] = {{"index", part.shard.index + 1}, {"count", part.shard.count}, {"plan", part.plan}};
        json["options"] = part.options;
        json["counts"] = part.counts;
    }
    return json.dump();
}

Result<PvsData> merge_parts(std::span<const Pvs> parts, std::span<const std::string> names) {
    Merger merger(parts, names);
    if (Status status = merger.check(); !status)
        return status;
    return merger.merge();
}

} // namespace antumbra
