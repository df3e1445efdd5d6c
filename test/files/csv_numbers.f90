!> The numbers of a CSV file in one call, for tests.
module csv_numbers
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t
    use gracecg_files_table, only: table_file_t, read_csv_table => read_csv
    implicit none
    private
    public :: read_csv

contains

    subroutine read_csv(path, columns, numbers, error, comments)
        character(*), intent(in) :: path, columns(:)
        real(dp), allocatable, intent(out) :: numbers(:, :)                 !! (row, column)
        type(error_t), allocatable, intent(out) :: error
        type(string_t), allocatable, intent(out), optional :: comments(:)   !! Lines without the #

        type(table_file_t) :: file

        call read_csv_table(path, columns, file, error)
        if (.not. allocated(error)) call file%get_numbers(columns, numbers, error)
        if (present(comments)) call move_alloc(file%comments, comments)
    end subroutine read_csv
end module csv_numbers
