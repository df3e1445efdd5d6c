# Writes the file SUMS anew when a module file in FOLDER is another than before (sums: flang's hold no time, nor do gfortran's).
file(GLOB files ${FOLDER}/*.mod)
foreach(path ${files})
    file(MD5 ${path} sum)
    string(APPEND sums "${sum} ${path}\n")
endforeach()
file(CONFIGURE OUTPUT ${SUMS} CONTENT "${sums}" @ONLY)
