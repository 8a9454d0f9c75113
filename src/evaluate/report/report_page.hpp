// The parts of the page, built in (cmake/EmbedReport.cmake).
#pragma once

#include <string_view>

namespace antumbra {

extern const std::string_view report_template, report_style, report_script, uplot_style, uplot_script;

} // namespace antumbra
