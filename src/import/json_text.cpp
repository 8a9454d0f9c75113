#include "import/json_text.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

struct Shape {
    int depth = 0;
    std::uint64_t values = 1;
};

/// Found without building anything, for the parser below allocates as it goes.
Shape shape_of(std::span<const std::byte> text) {
    Shape shape;
    int depth = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        char c = static_cast<char>(text[i]);
        if (quoted) {
            i += c == '\\';
            quoted = c != '"';
            continue;
        }
        quoted = c == '"';
        shape.values += c == ',' || c == '[' || c == '{';
        if (c == '[' || c == '{')
            shape.depth = std::max(shape.depth, ++depth);
        else if (c == ']' || c == '}')
            --depth;
    }
    return shape;
}

const Json kEmptyObject = Json::object();

} // namespace

Result<Json> parse_json(std::span<const std::byte> text, std::uint64_t max_memory) {
    Shape shape = shape_of(text);
    if (shape.depth > kJsonDepth)
        return Status(ErrorCode::limit, "JSON nests deeper than " + std::to_string(kJsonDepth) + " levels");
    if (shape.values > max_memory / kBytesPerJsonValue)
        return Status(ErrorCode::limit, "JSON holds " + std::to_string(shape.values) + " values, more than " +
                                            std::to_string(max_memory) + " bytes of memory can take");
    try {
        const char* begin = reinterpret_cast<const char*>(text.data());
        return Json::parse(begin, begin + text.size());
    } catch (const Json::parse_error& error) {
        return Status(ErrorCode::corrupt,
                      "is not valid JSON (byte " + std::to_string(error.byte) + "); write the file anew");
    } catch (const Json::exception&) {
        // Numbers beyond double, for instance.
        return Status(ErrorCode::corrupt, "is not valid JSON; write the file anew");
    }
}

JsonObject::JsonObject(const Json& value, std::string place, Status& status)
    : value_(&value), place_(std::move(place)), status_(&status) {
    if (!value.is_object()) {
        fail(ErrorCode::corrupt, "", "must be an object");
        value_ = &kEmptyObject;
    }
}

void JsonObject::fail(ErrorCode code, const char* key, const std::string& text) const {
    if (!status_->ok())
        return;
    std::string place = *key ? member_place(key) : place_;
    // A text that begins with an index goes on with the place.
    const char* between = place.empty() || text.front() == '[' ? "" : ": ";
    *status_ = Status(code, place + between + text);
}

const Json* JsonObject::find(const char* key) const {
    auto found = value_->find(key);
    return found == value_->end() ? nullptr : &*found;
}

const Json* JsonObject::find_array(const char* key) const {
    const Json* value = find(key);
    if (value && !value->is_array()) {
        fail(ErrorCode::corrupt, key, "must be an array");
        return nullptr;
    }
    return value;
}

std::string JsonObject::member_place(const char* key) const { return place_.empty() ? key : place_ + "." + key; }

std::string JsonObject::element_place(const char* key, std::size_t i) const {
    return member_place(key) + "[" + std::to_string(i) + "]";
}

std::uint64_t JsonObject::whole(const Json& value, const std::string& place, std::uint64_t max) const {
    std::uint64_t number = 0;
    bool good = false;
    if (value.is_number_unsigned()) {
        number = value.get<std::uint64_t>();
        good = true;
    } else if (value.is_number_float()) {
        double real = value.get<double>();
        good = real >= 0 && real <= 0x1p53 && real == std::floor(real);
        number = good ? static_cast<std::uint64_t>(real) : 0;
    }
    if (good && number <= max)
        return number;
    if (ok())
        *status_ = Status(ErrorCode::corrupt, place + (good ? ": " + std::to_string(number) + " is more than " +
                                                                  std::to_string(max)
                                                            : ": must be a whole number, not negative"));
    return 0;
}

std::uint64_t JsonObject::number(const char* key, std::uint64_t fallback, std::uint64_t max) const {
    const Json* value = find(key);
    return value ? whole(*value, member_place(key), max) : fallback;
}

std::uint64_t JsonObject::required_number(const char* key, std::uint64_t max) const {
    if (!has(key))
        fail(ErrorCode::corrupt, key, "is missing");
    return number(key, 0, max);
}

std::int32_t JsonObject::index(const char* key, std::size_t count) const {
    const Json* value = find(key);
    if (!value)
        return -1;
    std::uint64_t number = whole(*value, member_place(key), INT32_MAX);
    if (number >= count) {
        fail(ErrorCode::corrupt, key, "refers to " + std::to_string(number) + ", but there are only " +
                                          std::to_string(count));
        return -1;
    }
    return static_cast<std::int32_t>(number);
}

std::int32_t JsonObject::required_index(const char* key, std::size_t count) const {
    if (!has(key))
        fail(ErrorCode::corrupt, key, "is missing");
    return index(key, count);
}

double JsonObject::real(const char* key, double fallback) const {
    const Json* value = find(key);
    if (!value)
        return fallback;
    if (value->is_number() && std::isfinite(value->get<double>()))
        return value->get<double>();
    fail(ErrorCode::corrupt, key, "must be a finite number");
    return fallback;
}

bool JsonObject::boolean(const char* key, bool fallback) const {
    const Json* value = find(key);
    if (!value)
        return fallback;
    if (!value->is_boolean())
        fail(ErrorCode::corrupt, key, "must be true or false");
    return value->is_boolean() ? value->get<bool>() : fallback;
}

std::string JsonObject::text(const char* key) const {
    const Json* value = find(key);
    if (!value)
        return {};
    if (!value->is_string())
        fail(ErrorCode::corrupt, key, "must be a text");
    return value->is_string() ? value->get_ref<const std::string&>() : std::string();
}

bool JsonObject::reals(const char* key, std::span<double> values) const {
    const Json* array = find_array(key);
    if (!array)
        return false;
    bool good = array->size() == values.size();
    for (std::size_t i = 0; good && i < values.size(); ++i)
        good = (*array)[i].is_number() && std::isfinite((*array)[i].get<double>());
    if (!good) {
        fail(ErrorCode::corrupt, key, "must hold " + std::to_string(values.size()) + " finite numbers");
        return false;
    }
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = (*array)[i].get<double>();
    return true;
}

JsonObject JsonObject::object(const char* key) const {
    const Json* value = find(key);
    return JsonObject(value ? *value : kEmptyObject, member_place(key), *status_);
}

std::size_t JsonObject::size_of(const char* key) const {
    const Json* array = find_array(key);
    return array ? array->size() : 0;
}

} // namespace antumbra
