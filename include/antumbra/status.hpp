// Errors as values. Nothing in the library throws, prints or exits: whatever can fail returns a Status or a
// Result, whose message names the file, the place and the cure.
#pragma once

#include <cassert>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace antumbra {

/// Stable codes; the numbers are also those of `ant_status` in antumbra.h.
enum class ErrorCode : std::int32_t {
    ok = 0,
    usage = 1,       ///< an argument or option makes no sense
    io = 2,          ///< the disk or the file system refused
    corrupt = 3,     ///< a file is damaged, truncated or contradicts itself
    unsupported = 4, ///< a file is well formed but asks for what this version cannot do
    limit = 5,       ///< a stated limit (bytes, triangles, depth, ..) would be exceeded
    mismatch = 6,    ///< two inputs do not belong together (a .pvs of another scene)
    cancelled = 7,   ///< the caller asked to stop; what was finished is kept
    internal = 8,    ///< a broken promise of ours; please report
};

class [[nodiscard]] Status {
  public:
    Status() = default;
    Status(ErrorCode code, std::string message) : code_(code), message_(std::move(message)) {}

    bool ok() const { return code_ == ErrorCode::ok; }
    explicit operator bool() const { return ok(); }
    ErrorCode code() const { return code_; }
    /// One line, without a full stop at the end.
    const std::string& message() const { return message_; }
    /// The same error with "`where`: " in front, for callers that know the file or the place.
    Status in(const std::string& where) const {
        return ok() ? *this : Status(code_, where + ": " + message_);
    }

  private:
    ErrorCode code_ = ErrorCode::ok;
    std::string message_;
};

/// Either a value or the Status that says why there is none.
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : value_(std::move(value)) {}
    Result(Status status) : status_(std::move(status)) { assert(!status_.ok()); }

    bool ok() const { return status_.ok(); }
    explicit operator bool() const { return ok(); }
    const Status& status() const { return status_; }
    T& value() & { return (assert(value_), *value_); }
    const T& value() const& { return (assert(value_), *value_); }
    T&& value() && { return (assert(value_), std::move(*value_)); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }

  private:
    Status status_;
    std::optional<T> value_;
};

} // namespace antumbra
