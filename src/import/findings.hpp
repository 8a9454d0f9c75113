// Counts oddities by kind; keeps the first example of each.
#pragma once

#include <antumbra/scene.hpp>

#include <string>
#include <vector>

namespace antumbra {

/// `example` is a callable that gives a text; it is called for the first of a kind only.
template <class Example>
void add_finding(std::vector<Finding>& findings, const char* kind, Example&& example) {
    for (Finding& finding : findings)
        if (finding.kind == kind) {
            ++finding.count;
            return;
        }
    findings.push_back({kind, 1, example()});
}

} // namespace antumbra
