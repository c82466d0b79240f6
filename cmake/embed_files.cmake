# cmake -DOUT=HEADER -DFOLDER=FOLDER -P embed_files.cmake
# Writes a C++ header with the name and the text of every file in the folder.
file(GLOB names RELATIVE ${FOLDER} ${FOLDER}/*)
set(rows "")
foreach(name ${names})
  file(READ ${FOLDER}/${name} text)
  string(APPEND rows "    {\"${name}\", R\"-file-(${text})-file-\"},\n")
endforeach()
file(WRITE ${OUT} "#pragma once

#include <string_view>

namespace planar {

struct EmbeddedFile {
  const char* name;
  std::string_view text;
};

constexpr EmbeddedFile kConsolePage[] = {
${rows}};

}  // namespace planar
")
