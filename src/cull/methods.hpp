// The constructors of the methods, one file each. The neighbours never include each other.
#pragma once

#include <antumbra/cull.hpp>

#include <memory>

namespace antumbra {

using CullerPointer = std::unique_ptr<Culler>;

CullerPointer make_none(const CullScene& scene);
CullerPointer make_frustum_scalar(const CullScene& scene);
Result<CullerPointer> make_frustum(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_hzb(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_masked(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_published_planes(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_planes(const CullScene& scene, const CullerOptions& options);
/// tree-f, tree-fse, tree-fme, tree-fmc
Result<CullerPointer> make_tree_f(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_tree_fse(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_tree_fme(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_tree_fmc(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_tree(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_opacity(const CullScene& scene, const CullerOptions& options);
Result<CullerPointer> make_pvs(const CullScene& scene, const CullerOptions& options);

/// A number that no other culler of the process has, for ViewState::storage.
std::uint64_t new_culler_serial();

} // namespace antumbra
