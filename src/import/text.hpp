// Lines and words of untrusted text, without copies.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace antumbra {

/// Hands out logical lines: a backslash before a line's end joins it with the next, save in comments (`#`), which
/// may end in the path of a Windows folder. Linear in the text's length.
class Lines {
  public:
    explicit Lines(std::span<const std::byte> text)
        : rest_(reinterpret_cast<const char*>(text.data()), text.size()) {}

    /// False at the end. `line` is valid until the next call.
    bool next(std::string_view& line) {
        if (rest_.empty())
            return false;
        joined_.clear();
        for (bool joining = false;;) {
            std::size_t end = rest_.find('\n');
            std::string_view piece = rest_.substr(0, end);
            rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
            ++number_;
            if (!piece.empty() && piece.back() == '\r')
                piece.remove_suffix(1);
            bool comment = !joining && piece.substr(0, piece.find_first_not_of(" \t") + 1).ends_with('#');
            bool goes_on = !piece.empty() && piece.back() == '\\' && !comment;
            if (goes_on)
                piece.remove_suffix(1);
            goes_on = goes_on && !rest_.empty();
            if (!joining && !goes_on) {
                line = piece;
                return true;
            }
            joined_.append(piece);
            joined_ += ' ';
            joining = true;
            if (!goes_on) {
                line = joined_;
                return true;
            }
        }
    }
    /// Number of the last line that was read, from 1.
    std::uint64_t number() const { return number_; }

  private:
    std::string_view rest_;
    std::string joined_;
    std::uint64_t number_ = 0;
};

/// Cuts the next word off `line`; empty at its end.
inline std::string_view next_word(std::string_view& line) {
    std::size_t begin = line.find_first_not_of(" \t\r\v\f");
    if (begin == std::string_view::npos) {
        line = {};
        return {};
    }
    line.remove_prefix(begin);
    std::size_t end = line.find_first_of(" \t\r\v\f");
    std::string_view word = line.substr(0, end);
    line.remove_prefix(word.size());
    return word;
}

/// What is left of a line, without blanks around it.
inline std::string_view trimmed(std::string_view text) {
    std::size_t begin = text.find_first_not_of(" \t\r\v\f");
    if (begin == std::string_view::npos)
        return {};
    return text.substr(begin, text.find_last_not_of(" \t\r\v\f") - begin + 1);
}

} // namespace antumbra
