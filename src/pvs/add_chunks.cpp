// Chunks beside those of the bake: put into a file, found in it.
#include "pvs/format.hpp"

#include <antumbra/pvs.hpp>

#include <algorithm>

namespace antumbra {
namespace {

bool is_name(std::string_view name) {
    return name.size() == 4 && std::all_of(name.begin(), name.end(), [](char c) {
               return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
           });
}

ChunkId id_of(std::string_view name) { return chunk_id({name[0], name[1], name[2], name[3], '\0'}); }

Status check_names(std::span<const PvsChunk> chunks) {
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        if (!is_name(chunks[i].name) || is_chunk_of_bake(id_of(chunks[i].name)))
            return {ErrorCode::usage, "add_pvs_chunks: '" + chunks[i].name +
                                          "' is no name for a chunk: four capital letters or digits, none that a bake uses"};
        for (std::size_t j = 0; j < i; ++j)
            if (chunks[j].name == chunks[i].name)
                return {ErrorCode::usage, "add_pvs_chunks: chunk '" + chunks[i].name + "' is given twice"};
    }
    return {};
}

} // namespace

Result<std::vector<std::byte>> add_pvs_chunks(std::span<const std::byte> file, std::span<const PvsChunk> chunks) {
    if (Status status = check_names(chunks); !status)
        return status;
    Result<std::vector<Section>> old = read_chunks(file);
    if (!old)
        return old.status();
    std::vector<Section> sections;
    for (const Section& section : *old)
        if (std::none_of(chunks.begin(), chunks.end(), [&](const PvsChunk& c) { return id_of(c.name) == section.id; }))
            sections.push_back(section);
    for (const PvsChunk& chunk : chunks)
        sections.push_back({id_of(chunk.name), 0, chunk.bytes});
    return write_chunks(sections);
}

std::span<const std::byte> Pvs::chunk(std::string_view name) const {
    if (is_name(name))
        for (const OtherChunk& other : others_)
            if (other.id == std::uint32_t(id_of(name)))
                return other.bytes;
    return {};
}

bool Pvs::has_chunk(std::string_view name) const {
    return is_name(name) && std::any_of(others_.begin(), others_.end(), [&](const OtherChunk& other) {
               return other.id == std::uint32_t(id_of(name));
           });
}

} // namespace antumbra
