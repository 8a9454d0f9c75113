#include "bake/exact/certificate_bytes.hpp"

namespace antumbra::certificates {

void put_number(ByteWriter& out, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7)
        out.u8(std::uint8_t(value | 0x80));
    out.u8(std::uint8_t(value));
}
void put_signed(ByteWriter& out, std::int64_t value) {
    put_number(out, std::uint64_t(value) << 1 ^ std::uint64_t(value >> 63));
}
void put_integer(ByteWriter& out, const Integer& value) {
    std::vector<unsigned char> bytes;
    Integer magnitude = abs(value);
    if (magnitude != 0)
        export_bits(magnitude, std::back_inserter(bytes), 8, false);
    put_number(out, std::uint64_t(bytes.size()) << 1 | std::uint64_t(value < 0));
    for (unsigned char byte : bytes)
        out.u8(byte);
}
void put_point(ByteWriter& out, const GridPoint& p) {
    for (int k = 0; k < 3; ++k)
        put_signed(out, p[k]);
}

void put_rational_point(ByteWriter& out, const Vec3<certify::Rational>& p) {
    for (int k = 0; k < 3; ++k) {
        put_integer(out, numerator(p[k]));
        put_integer(out, denominator(p[k]));
    }
}

Vec3<certify::Rational> get_rational_point(Reader& in) {
    Vec3<certify::Rational> p;
    for (int k = 0; k < 3; ++k) {
        Integer above = in.integer(), below = in.integer();
        if (below <= 0)
            in.fail();
        p[k] = in.ok() ? certify::Rational(above, below) : certify::Rational(0);
    }
    return p;
}

void put_tree(ByteWriter& out, const HiddenTree& tree) {
    put_number(out, tree.nodes.size());
    for (const HiddenTree::Node& node : tree.nodes) {
        out.u8(std::uint8_t(node.kind));
        if (node.kind == HiddenTree::Kind::split) {
            for (const Integer& coordinate : node.hyperplane)
                put_integer(out, coordinate);
            put_signed(out, node.child[0]);
            put_signed(out, node.child[1]);
        } else if (node.kind == HiddenTree::Kind::blocked) {
            put_number(out, node.occluder);
            out.u8(std::uint8_t(node.crossing + 1));
        }
    }
}

HiddenTree get_tree(Reader& in, std::size_t blockers) {
    HiddenTree tree;
    std::size_t nodes = in.count();
    for (std::size_t n = 0; n < nodes && in.ok(); ++n) {
        HiddenTree::Node node;
        std::uint8_t kind = in.byte();
        if (kind > std::uint8_t(HiddenTree::Kind::blocked))
            in.fail();
        node.kind = HiddenTree::Kind(kind);
        if (node.kind == HiddenTree::Kind::split) {
            for (Integer& coordinate : node.hyperplane)
                coordinate = in.integer();
            for (std::int32_t& child : node.child) {
                std::int64_t index = in.signed_number();
                if (index < 0 || std::uint64_t(index) >= nodes)
                    in.fail();
                child = std::int32_t(index);
            }
        } else if (node.kind == HiddenTree::Kind::blocked) {
            std::uint64_t occluder = in.number();
            if (occluder >= blockers)
                in.fail();
            node.occluder = std::uint32_t(occluder);
            node.crossing = std::int8_t(in.byte() - 1);
        }
        tree.nodes.push_back(std::move(node));
    }
    return tree;
}

} // namespace antumbra::certificates
