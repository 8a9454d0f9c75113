# antumbra::evaluate: truth, walkthrough, report. The only library that needs GL and brings HTML.
antumbra_library(evaluate evaluate)
target_link_libraries(antumbra_evaluate PUBLIC antumbra_antumbra
                      PRIVATE $<BUILD_INTERFACE:nlohmann_json::nlohmann_json>)
