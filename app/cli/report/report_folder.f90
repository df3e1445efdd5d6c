!> The folder of `gracecg report`: a CSV file for each table of numbers, and result.json with what is no table. The Python
!> package makes the page of them (`gracecg.report`).
module gracecg_cli_report_folder
    use, intrinsic :: iso_fortran_env, only: compiler_version
    use gracecg_base_statistics, only: sampling_error
    use gracecg_base_version, only: file_comments
    use gracecg_files_file, only: make_directory, remove_file
    use gracecg_cli_campaign_tables, only: REPORT_RUNS
    use gracecg_cli_page_program, only: make_page, RESULT_FILE
    use gracecg_cli_work
    implicit none
    private
    public :: report_folder_t, open_report, COMMAND, PAGE_NAME

    character(*), parameter :: COMMAND = 'report'           !! Name of the command
    character(*), parameter :: PAGE_NAME = 'index.html'     !! Name of the page in the folder

    !> The folder as it fills, and how its numbers are computed.
    type :: report_folder_t
        integer :: runs = 0                         !! Of every Monte Carlo
        integer :: threads = 1                      !! To work on
        integer(i8) :: seed = 1                     !! Of the random numbers
        type(results_t) :: results                  !! result.json in the making
        character(:), allocatable, private :: path
        type(string_t), allocatable, private :: names(:)    !! Of the CSV files
    contains
        procedure :: file                   !! The path of a new file, which is noted
        procedure :: put                    !! Writes a table
        procedure :: finish                 !! Writes result.json and makes the page
    end type report_folder_t

contains

    !> Begins the folder, which is made where there is none. A page and a result.json of before go at once: they would tell
    !> of files that are no longer theirs. Fails when nothing can be written there.
    subroutine open_report(path, runs, seed, threads, folder, error)
        character(*), intent(in) :: path            !! Of the folder
        integer, intent(in) :: runs, threads        !! Of every Monte Carlo; in parallel
        integer(i8), intent(in) :: seed             !! Of the random numbers
        type(report_folder_t), intent(out) :: folder
        type(error_t), allocatable, intent(out) :: error

        call make_directory(path, error)
        if (.not. allocated(error)) call check_writable(path//'/'//PAGE_NAME, error)
        if (allocated(error)) return
        call remove_file(path//'/'//PAGE_NAME)
        call remove_file(path//'/'//RESULT_FILE)
        folder%path = path
        folder%runs = runs
        folder%seed = seed
        folder%threads = threads
        allocate (folder%names(0))
        call folder%results%open(COMMAND)
        call folder%results%member('compiler', compiler_version())
        call folder%results%member('runs', runs)
        call folder%results%member('report_runs', REPORT_RUNS)
        call folder%results%member('seed', seed)
        call folder%results%member('sampling_error', sampling_error(runs))
    end subroutine open_report

    !> The path of a new file, which is noted.
    function file(self, name) result(path)
        class(report_folder_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Of the file, with its ending
        character(:), allocatable :: path

        call append(self%names, name)
        path = self%path//'/'//name
    end function file

    !> Writes a table as NAME.csv. Fails when a number is not finite, or the file cannot be written.
    subroutine put(self, name, table, about, error)
        class(report_folder_t), intent(inout) :: self
        character(*), intent(in) :: name            !! Of the table
        type(data_table_t), intent(in) :: table
        character(*), intent(in) :: about           !! Its settings, for NAME.csv.meta.json
        type(error_t), allocatable, intent(out) :: error

        call table%write(self%file(name//'.csv'), file_comments(COMMAND, about), error)
    end subroutine put

    !> Writes result.json and makes the page; shows what the page's maker says.
    subroutine finish(self, console, error)
        class(report_folder_t), intent(inout) :: self
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: json, said

        call self%results%member('files', self%names)
        call self%results%end()
        call self%results%finish(json, error)
        if (.not. allocated(error)) call make_page(self%path//'/'//PAGE_NAME, json, error, self%path, said)
        if (allocated(error)) return
        call console%line(said)
        call console%line('written to '//self%path)
    end subroutine finish
end module gracecg_cli_report_folder
