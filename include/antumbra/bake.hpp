// Baking: what is visible from every cell of viewpoints, computed once.
#pragma once

#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

namespace antumbra {

struct BakeOptions {
    std::string method = "sampled";
    /// The grid: a count per axis, or, if cell_size > 0, cubes of about that edge (scene units).
    std::array<std::uint32_t, 3> cells{16, 4, 16};
    double cell_size = 0;
    /// Where viewers can be (world). Empty: the scene's bounds. Cells that touch none of them are not baked.
    std::vector<Box3d> where;
    /// Directions sampled uniformly per cell, and rays aimed at each object that those did not find.
    std::uint32_t rays_per_cell = 32768;
    std::uint32_t rays_per_object = 32;
    /// Rays per cell that only measure the miss rate, from a stream of their own.
    std::uint32_t holdout_rays = 2048;
    std::uint64_t seed = 1;
    /// Where to keep finished cells while baking ("" = nowhere), and whether to take up what is there.
    std::string checkpoint;
    bool resume = false;
};

/// What a bake measured. `bytes` and `bits_per_pair` belong to the file and are filled by whoever writes it.
struct BakeStatistics {
    std::uint64_t cells = 0, cells_baked = 0, cells_solid = 0, cells_not_baked = 0, cells_resumed = 0;
    std::uint64_t rays = 0;
    std::uint64_t confirmed_pairs = 0;   ///< (cell, object) bits, each proved by one exact segment
    std::uint64_t unconfirmed_pairs = 0; ///< proposed by a ray, never confirmed: not set
    double seconds = 0, cpu_seconds = 0;
    double mean_visible = 0; ///< objects per baked cell
    std::uint64_t holdout_rays = 0, holdout_misses = 0;
    double miss_rate = 0, miss_rate_upper95 = 0; ///< a fresh random ray of a cell first hits an unlisted object
    double pair_s1 = 0.1, pair_miss_at_s1 = 0;   ///< bound for pairs that a share s >= pair_s1 of aimed rays sees
};

struct BakeResult {
    PvsData pvs;
    BakeStatistics statistics;
};

struct BakePlan {
    CellGrid grid;
    std::uint64_t cells_to_bake = 0;
    double estimated_seconds = 0; ///< from a few cells baked for the purpose
    std::uint64_t estimated_bytes = 0;
};

/// A pure function of (scene, options): the same result, byte for byte, for any job.threads, and whether or not it
/// was interrupted and resumed. ErrorCode::cancelled keeps finished cells in the checkpoint.
Result<BakeResult> bake(const Scene& scene, const BakeOptions& options, const Job& job = {});

/// What bake() would do, from a handful of cells.
Result<BakePlan> plan_bake(const Scene& scene, const BakeOptions& options, const Job& job = {});

} // namespace antumbra
