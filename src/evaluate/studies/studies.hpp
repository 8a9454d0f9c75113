// The studies, one file per paper. Each is added to the list in studies.cpp.
#pragma once

#include <antumbra/study.hpp>

namespace antumbra {

Result<Study> study_bittner(const Scene& scene, const StudyOptions& options, const Job& job);
Result<Study> study_coorg_teller(const Scene& scene, const StudyOptions& options, const Job& job);
Result<Study> study_nirenstein(const Scene& scene, const StudyOptions& options, const Job& job);

/// `antumbra generate downtown` is the scene for it; it finds its own routes and needs no path.
Result<Study> study_poon_wang(const Scene& scene, const StudyOptions& options, const Job& job);

} // namespace antumbra
