// JSON from untrusted text, with a bounded depth, and a reader of members whose errors name their place.
#pragma once

#include <antumbra/status.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace antumbra {

using Json = nlohmann::json;

/// Deepest nesting of arrays and objects that any of our readers needs is 8; extras may nest deeper.
inline constexpr int kJsonDepth = 128;

/// What a parsed value may cost in memory, key and allocator included.
inline constexpr std::uint64_t kBytesPerJsonValue = 128;

/// ErrorCode::corrupt names the byte; ErrorCode::limit beyond kJsonDepth, or if the parsed document might need more
/// than `max_memory` bytes. Nothing escapes as an exception.
Result<Json> parse_json(std::span<const std::byte> text, std::uint64_t max_memory = std::uint64_t(1) << 30);

/// One JSON object and its place in the document, e.g. "accessors[12]". Every getter checks type and range; the
/// first thing that is wrong stays in the shared status (the getters then return their fallback), so that a caller
/// reads a whole object and looks once.
class JsonObject {
  public:
    JsonObject(const Json& value, std::string place, Status& status);

    const std::string& place() const { return place_; }
    bool ok() const { return status_->ok(); }
    bool has(const char* key) const { return find(key) != nullptr; }
    const Json& json() const { return *value_; }

    /// A whole number in 0..`max`. Writers that say 3.0 for 3 are understood.
    std::uint64_t number(const char* key, std::uint64_t fallback, std::uint64_t max = UINT64_MAX) const;
    /// The same, but the member must be there.
    std::uint64_t required_number(const char* key, std::uint64_t max = UINT64_MAX) const;
    /// An index below `count`; -1 if there is no such member.
    std::int32_t index(const char* key, std::size_t count) const;
    std::int32_t required_index(const char* key, std::size_t count) const;
    double real(const char* key, double fallback) const;
    bool boolean(const char* key, bool fallback) const;
    std::string text(const char* key) const;
    /// Exactly `values.size()` finite numbers; false, and `values` untouched, if there is no such member.
    bool reals(const char* key, std::span<double> values) const;
    /// An empty object if there is no such member.
    JsonObject object(const char* key) const;

    /// Calls visit(JsonObject, i) for each object of the array `key`, until the first error.
    template <class Visit>
    void for_each_object(const char* key, Visit&& visit) const {
        const Json* array = find_array(key);
        for (std::size_t i = 0; array && i < array->size() && ok(); ++i)
            visit(JsonObject((*array)[i], element_place(key, i), *status_), i);
    }
    /// Calls visit(index, i) for each index below `count` of the array `key`, until the first error.
    template <class Visit>
    void for_each_index(const char* key, std::size_t count, Visit&& visit) const {
        const Json* array = find_array(key);
        for (std::size_t i = 0; array && i < array->size(); ++i) {
            std::uint64_t value = whole((*array)[i], element_place(key, i), count == 0 ? 0 : count - 1);
            if (count == 0)
                fail(ErrorCode::corrupt, key, "refers to something that does not exist");
            if (!ok())
                return;
            visit(static_cast<std::int32_t>(value), i);
        }
    }
    /// Number of elements of the array `key`; 0 if there is none.
    std::size_t size_of(const char* key) const;

    /// Records an error at the member `key` ("": at the object itself) unless there is one already.
    void fail(ErrorCode code, const char* key, const std::string& text) const;

  private:
    const Json* find(const char* key) const;
    const Json* find_array(const char* key) const;
    std::string member_place(const char* key) const;
    std::string element_place(const char* key, std::size_t i) const;
    std::uint64_t whole(const Json& value, const std::string& place, std::uint64_t max) const;

    const Json* value_;
    std::string place_;
    Status* status_;
};

} // namespace antumbra
