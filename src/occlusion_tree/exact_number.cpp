#include "occlusion_tree/exact_number.hpp"

namespace antumbra {
namespace {

/// Products between these bounds have exact errors.
constexpr double kSmallest = 0x1p-900, kLargest = 0x1p900;

bool is_safe(double product) {
    return product == 0 || (std::abs(product) > kSmallest && std::abs(product) < kLargest);
}

} // namespace

ExactNumber ExactNumber::difference(double a, double b) {
    ExactNumber result;
    double high, low;
    exact::two_sum(a, -b, high, low);
    for (double term : {low, high})
        if (term != 0)
            result.terms_[result.count_++] = term;
    result.broken_ = !is_safe(high);
    return result;
}

ExactNumber ExactNumber::operator-() const {
    ExactNumber result;
    for (std::size_t i = 0; i < count_; ++i)
        result.terms_[i] = -terms_[i];
    result.count_ = count_;
    result.broken_ = broken_;
    return result;
}

ExactNumber ExactNumber::operator+(const ExactNumber& other) const {
    ExactNumber result;
    result.broken_ = broken_ || other.broken_ || count_ + other.count_ > kRoom;
    if (!result.broken_) {
        result.count_ = exact::sum(terms(), other.terms(), result.terms_.data());
        result.compress();
    }
    return result;
}

ExactNumber ExactNumber::operator-(const ExactNumber& other) const { return *this + -other; }

ExactNumber ExactNumber::operator*(const ExactNumber& other) const {
    ExactNumber result;
    result.broken_ = broken_ || other.broken_;
    for (std::size_t f = 0; f < other.count_ && !result.broken_; ++f) {
        for (std::size_t i = 0; i < count_; ++i)
            result.broken_ |= !is_safe(terms_[i] * other.terms_[f]) || terms_[i] * other.terms_[f] == 0;
        if (2 * count_ + result.count_ > kRoom || result.broken_) {
            result.broken_ = true;
            break;
        }
        std::array<double, kRoom> part, before = result.terms_;
        std::size_t parts = exact::scale(terms(), other.terms_[f], part.data());
        result.count_ = exact::sum({before.data(), result.count_}, {part.data(), parts}, result.terms_.data());
        result.compress();
    }
    return result;
}

void ExactNumber::compress() {
    if (count_ < 2)
        return;
    std::array<double, kRoom> down;
    std::size_t kept = 0;
    double carry = terms_[count_ - 1];
    for (std::size_t i = count_ - 1; i-- > 0;) {
        double high, low;
        exact::fast_two_sum(carry, terms_[i], high, low);
        if (low != 0) {
            down[kept++] = high;
            high = low;
        }
        carry = high;
    }
    down[kept++] = carry;
    count_ = 0;
    carry = down[kept - 1];
    for (std::size_t i = kept - 1; i-- > 0;) {
        double high, low;
        exact::fast_two_sum(down[i], carry, high, low);
        if (low != 0)
            terms_[count_++] = low;
        carry = high;
    }
    if (carry != 0)
        terms_[count_++] = carry;
}

} // namespace antumbra
