// Bits per (row, object) pair of every coding on a matrix of visibility, beside what others use, and the time to decode
// a row. usage: bench_coding MATRIX.. ; a MATRIX is a file that bench/extract_matrix.py wrote.
#include "base/file.hpp"
#include "pvs/coding_archive.hpp"
#include "pvs/coding_references.hpp"
#include "pvs/coding_tree.hpp"
#include "pvs/row_coding.hpp"

#include <cstdio>
#include <ctime>
#include <functional>
#include <string>
#include <zlib.h>
#ifdef ANTUMBRA_HAS_ZSTD
#include <zstd.h>
#endif

namespace antumbra {
namespace {

struct Matrix {
    std::uint32_t rows = 0, objects = 0;
    std::vector<std::uint64_t> bits;
    std::vector<std::byte> raw; ///< rows of whole bytes
};

/// u32 rows, u32 objects, then rows of (objects + 7) / 8 bytes, the first object in the lowest bit.
Matrix read_matrix(std::span<const std::byte> bytes) {
    Matrix matrix;
    matrix.rows = load_u32(bytes, 0);
    matrix.objects = load_u32(bytes, 4);
    matrix.raw.assign(bytes.begin() + 8, bytes.end());
    std::size_t row_bytes = bytes_for(matrix.objects), words = words_for(matrix.objects);
    matrix.bits.resize(matrix.rows * words);
    for (std::size_t r = 0; r < matrix.rows; ++r)
        for (std::size_t i = 0; i < row_bytes; ++i)
            matrix.bits[r * words + i / 8] |= std::uint64_t(matrix.raw[r * row_bytes + i]) << (i % 8 * 8);
    return matrix;
}

/// id Software's run-length coding: a zero byte and how many, everything else as it is; and a 32-bit offset per row.
std::size_t quake_bytes(const Matrix& matrix) {
    std::size_t row_bytes = bytes_for(matrix.objects), total = 4 * std::size_t(matrix.rows);
    for (std::size_t r = 0; r < matrix.rows; ++r)
        for (std::size_t i = 0; i < row_bytes; ++i) {
            total += 1;
            if (matrix.raw[r * row_bytes + i] != std::byte(0))
                continue;
            std::size_t run = 1;
            while (run < 255 && i + 1 < row_bytes && matrix.raw[r * row_bytes + i + 1] == std::byte(0)) {
                ++run;
                ++i;
            }
            total += 1;
        }
    return total;
}

std::size_t zlib_bytes(const Matrix& matrix) {
    uLongf size = compressBound(uLong(matrix.raw.size()));
    std::vector<Bytef> out(size);
    compress2(out.data(), &size, reinterpret_cast<const Bytef*>(matrix.raw.data()), uLong(matrix.raw.size()), 9);
    return size;
}

/// Processor time: other work on the machine does not count.
double seconds(const std::function<void()>& work) {
    std::clock_t start = std::clock();
    work();
    return double(std::clock() - start) / CLOCKS_PER_SEC;
}

void print(const char* name, const Matrix& matrix, std::size_t bytes, double encode_seconds, double decode_seconds,
           const char* access) {
    double pairs = double(matrix.rows) * matrix.objects;
    std::printf("  %-22s %9zu bytes  %7.4f bits/pair  encode %7.3f s  decode %8.3f us/row  %s\n", name, bytes,
                double(bytes) * 8 / pairs, encode_seconds, decode_seconds / matrix.rows * 1e6, access);
}

void measure_cheapest(const Matrix& matrix) {
    std::size_t words = words_for(matrix.objects);
    ByteWriter out;
    std::vector<std::size_t> ends{0};
    double encode = seconds([&] {
        for (std::size_t r = 0; r < matrix.rows; ++r) {
            encode_row(std::span(matrix.bits).subspan(r * words, words), matrix.objects, out);
            ends.push_back(out.bytes.size());
        }
    });
    std::vector<std::uint64_t> row(words);
    double decode = seconds([&] {
        for (std::size_t r = 0; r < matrix.rows; ++r)
            (void)decode_row(std::span(out.bytes).subspan(ends[r], ends[r + 1] - ends[r]), matrix.objects, row);
    });
    print("1 cheapest", matrix, out.bytes.size() + 4 * matrix.rows, encode, decode, "any row");
}

/// A complete binary tree over the rows in their order (that of the map's space partition).
void measure_tree(const Matrix& matrix, TreeCoding coding, const char* name) {
    std::vector<std::uint32_t> cell_row(matrix.rows);
    for (std::uint32_t r = 0; r < matrix.rows; ++r)
        cell_row[r] = r;
    CodingTree tree = coding_tree_of(CellGrid{{{0, 0, 0}, {1, 1, 1}}, {matrix.rows, 1, 1}}, cell_row);
    std::vector<std::byte> coded;
    double encode = seconds([&] { coded = encode_tree_rows(tree, coding, matrix.bits, matrix.objects); });
    double decode = seconds([&] {
        (void)decode_tree_rows(tree, coding, coded, matrix.objects, [](std::uint32_t, std::span<const std::uint64_t>) {});
    });
    print(name, matrix, coded.size(), encode, decode, "all at once");
}

void measure_references(const Matrix& matrix, std::uint32_t depth) {
    CodedReferences coded;
    double encode = seconds([&] { coded = encode_references(matrix.bits, matrix.rows, matrix.objects, depth); });
    ReferenceRows rows(coded.index, coded.rows, matrix.rows, matrix.objects);
    std::vector<std::uint64_t> row(words_for(matrix.objects));
    bool right = true;
    double decode = seconds([&] {
        for (std::uint32_t r = 0; r < matrix.rows; ++r) {
            rows.decode(r, row);
            right = right && std::equal(row.begin(), row.end(), matrix.bits.begin() + std::ptrdiff_t(r * row.size()));
        }
    });
    std::string name = "5 references, depth " + std::to_string(depth);
    print(name.c_str(), matrix, coded.index.size() + coded.rows.size(), encode, decode, right ? "any row" : "WRONG");
}

void measure_archive(const Matrix& matrix) {
    std::vector<std::byte> coded;
    double encode = seconds([&] { coded = encode_archive(matrix.bits, matrix.rows, matrix.objects); });
    bool right = false;
    double decode = seconds([&] { right = *decode_archive(coded, matrix.rows, matrix.objects) == matrix.bits; });
    print("6 archive", matrix, coded.size(), encode, decode, right ? "all at once" : "WRONG");
}

void measure(const char* path) {
    Result<MappedFile> file = MappedFile::open(path);
    if (!file || file->bytes().size() < 8) {
        std::fprintf(stderr, "%s: no matrix\n", path);
        return;
    }
    Matrix matrix = read_matrix(file->bytes());
    std::printf("%s: %u rows, %u objects\n", path, matrix.rows, matrix.objects);
    print("raw", matrix, matrix.raw.size(), 0, 0, "any row");
    print("Quake run-length", matrix, quake_bytes(matrix), 0, 0, "any row");
    print("zlib -9", matrix, zlib_bytes(matrix), 0, 0, "all at once");
#ifdef ANTUMBRA_HAS_ZSTD
    std::vector<std::byte> out(ZSTD_compressBound(matrix.raw.size()));
    print("zstd -19", matrix, ZSTD_compress(out.data(), out.size(), matrix.raw.data(), matrix.raw.size(), 19), 0, 0,
          "all at once");
#endif
    measure_cheapest(matrix);
    measure_tree(matrix, TreeCoding::leaves, "2 tree, leaves");
    measure_tree(matrix, TreeCoding::parent, "3 tree, parent");
    measure_tree(matrix, TreeCoding::sibling, "4 tree, sibling");
    for (std::uint32_t depth : {4u, 8u, 16u})
        measure_references(matrix, depth);
    measure_archive(matrix);
}

} // namespace
} // namespace antumbra

int main(int argc, char** argv) {
    for (int i = 1; i < argc; ++i)
        antumbra::measure(argv[i]);
    return argc > 1 ? 0 : 2;
}
