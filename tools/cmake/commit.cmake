# The commit of the sources, for what the program writes: looked up in every build.
set(commit ${PROJECT_BINARY_DIR}/commit)
add_custom_target(commit COMMAND ${PROJECT_SOURCE_DIR}/tools/commit.sh ${commit} BYPRODUCTS ${commit}/build_commit.inc)
set_source_files_properties(app/main.f90 PROPERTIES OBJECT_DEPENDS ${commit}/build_commit.inc)
target_include_directories(gracecg-program BEFORE PRIVATE ${commit})
