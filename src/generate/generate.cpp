#include "generate/kinds.hpp"

namespace antumbra {
namespace {

using Generator = Result<RawScene> (*)(const GenerateOptions&);

constexpr std::string_view kNames[] = {"apartment", "city", "downtown", "forest", "forest-dense",
                                         "machine", "office", "town"};
constexpr Generator kGenerators[] = {generation::apartment, generation::city,   generation::downtown,
                                     generation::forest,    generation::forest_dense, generation::machine,
                                     generation::office,    generation::town};
static_assert(std::size(kNames) == std::size(kGenerators));

} // namespace

std::span<const std::string_view> generator_names() {
    return kNames;
}

Result<RawScene> generate(std::string_view kind, const GenerateOptions& options) {
    std::string known;
    for (std::size_t i = 0; i < std::size(kNames); ++i) {
        if (kNames[i] == kind && options.copies != 1 && kind != "apartment")
            return Status(ErrorCode::usage, "only the apartment can be copied, not the " + std::string(kind));
        if (kNames[i] == kind && (options.storeys != 0 || options.plants != 0) && kind != "office")
            return Status(ErrorCode::usage, "only the office takes a number of storeys or plants, not the " + std::string(kind));
        if (kNames[i] == kind)
            return kGenerators[i](options);
        known += (i ? ", " : "") + std::string(kNames[i]);
    }
    return Status(ErrorCode::usage,
                  "no kind of scene is called '" + std::string(kind) + "'; known: " + known);
}

} // namespace antumbra
