# cmake -DOUTPUT=X.cpp -DHEADER=Y.hpp -DNAMESPACE=N -DPARTS="name=file;.." -P EmbedText.cmake: writes the files as string
# constants of C++, which Y.hpp declares.
set(text "#include \"${HEADER}\"\n\nnamespace ${NAMESPACE} {\n")
foreach(part IN LISTS PARTS)
  string(REGEX MATCH "^([a-z_]+)=(.*)$" matched "${part}")
  set(name "${CMAKE_MATCH_1}")
  file(READ "${CMAKE_MATCH_2}" content)
  string(APPEND text "const std::string_view ${name} = R\"antumbra(${content})antumbra\";\n")
endforeach()
string(APPEND text "} // namespace ${NAMESPACE}\n")
file(WRITE "${OUTPUT}" "${text}")
