!> The result of a command for programs: JSON with everything that the text shows, and CSV of its table.
module gracecg_cli_results
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, split
    use gracecg_base_version, only: VERSION, file_comments
    use gracecg_files_json, only: json_writer_t, put_provenance
    use gracecg_files_data_table, only: data_table_t
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: results_t, FORMATS, add_format_option, take_format, publish_row, put_columns, axis_columns

    character(4), parameter :: FORMATS(3) = [character(4) :: 'text', 'csv', 'json']    !! Values of --format

    !> A JSON object in the making; what is the command's own is put in by `member`, `begin` and `end`.
    type, extends(json_writer_t) :: results_t
        character(:), allocatable, private :: command       !! As typed: 'model gravity'
    contains
        procedure :: open => open_results   !! Program, version and command
        procedure :: publish                !! Ends the object and prints what is asked for
        procedure :: complete               !! Ends the object: the text
    end type results_t

contains

    !> Declares the option --format.
    subroutine add_format_option(arguments, default)
        type(arguments_t), intent(inout) :: arguments
        character(*), intent(in), optional :: default   !! One of FORMATS; absent: text

        character(:), allocatable :: usual

        usual = 'text'
        if (present(default)) usual = default
        call arguments%add_option('--format', 'FORMAT', 'text, csv or json', choices=FORMATS, default=usual)
    end subroutine add_format_option

    !> What standard output is to be: text for people, the table as CSV, or everything as JSON.
    subroutine take_format(arguments, console, misuse)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: misuse     !! The format is another

        character(:), allocatable :: chosen

        call arguments%get('--format', chosen, misuse)
        if (.not. allocated(misuse)) console%format = chosen
    end subroutine take_format

    !> Begins the object.
    subroutine open_results(self, command)
        class(results_t), intent(inout) :: self
        character(*), intent(in) :: command     !! As typed: 'model gravity'

        self%command = command
        call self%begin()
        call self%member('program', 'gracecg')
        call self%member('version', VERSION)
        call self%member('command', command)
        call put_provenance(self)
    end subroutine open_results

    !> Prints the result: of JSON the object with the table's rows and the warnings, of CSV the table, of text
    !> nothing, for that has been written line by line. Writes the table into a file, too, where one is asked for. Fails
    !> when a number is not finite, or the file cannot be written.
    subroutine publish(self, table, console, error, path, about, json)
        class(results_t), intent(inout) :: self
        type(data_table_t), intent(in) :: table         !! Its rows are the member `results`
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: path      !! Of the CSV file; empty: none
        character(*), intent(in), optional :: about     !! Of that file: what it was made with
        character(:), allocatable, intent(out), optional :: json    !! The object, whatever is printed

        type(string_t), allocatable :: lines(:)
        character(:), allocatable :: text
        integer :: i

        if (console%format == 'json' .or. present(json)) call self%complete(table, console, text, error)
        if (allocated(error)) return
        if (console%format == 'json') call console%data(text)
        if (console%format == 'csv') then
            call table%csv(lines, error)
            if (allocated(error)) return
            do i = 1, size(lines)
                call console%data(lines(i)%text)
            end do
        end if
        if (present(json)) json = text
        if (.not. present(path)) return
        if (path /= '') call table%write(path, file_comments(self%command, about), error)
    end subroutine publish

    !> Ends the object with the table's rows and the warnings. Fails when a number is not finite.
    subroutine complete(self, table, console, text, error)
        class(results_t), intent(inout) :: self
        type(data_table_t), intent(in) :: table         !! Its rows are the member `results`
        type(console_t), intent(in) :: console
        character(:), allocatable, intent(out) :: text  !! The JSON
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: warnings(:)

        allocate (warnings(0))
        if (allocated(console%warnings)) warnings = console%warnings
        call table%to_json(self, 'results')
        call self%member('warnings', warnings)
        call self%end()
        call self%finish(text, error)
    end subroutine complete

    !> Declares three columns of a table below one heading: x, y, z in the names.
    subroutine axis_columns(table, before, behind, layout, heading)
        type(data_table_t), intent(inout) :: table
        character(*), intent(in) :: before, behind      !! Of the axis in the column's name
        character(*), intent(in) :: layout              !! For people, of one value
        character(*), intent(in) :: heading             !! For people, of all three

        integer :: axis

        call table%column(before//AXES(1)//behind, layout, heading//'|'//AXES(1))
        do axis = 2, size(AXES)
            call table%column(before//AXES(axis)//behind, layout, '|'//AXES(axis))
        end do
    end subroutine axis_columns

    !> Three series as columns of a table: x, y, z in the names.
    subroutine put_columns(json, before, behind, values)
        class(json_writer_t), intent(inout) :: json     !! In the table's object
        character(*), intent(in) :: before, behind      !! Of the axis in the column's name
        real(dp), intent(in) :: values(:, :)            !! (axis, row)

        integer :: axis

        do axis = 1, size(AXES)
            call json%member(before//AXES(axis)//behind, values(axis, :))
        end do
    end subroutine put_columns

    !> One row of numbers as the result of a command.
    subroutine publish_row(command, columns, values, console, error, note)
        character(*), intent(in) :: command         !! As typed: 'model gravity'
        character(*), intent(in) :: columns         !! Names, separated by commas, each with its unit: ax_m_s2
        real(dp), intent(in) :: values(:)           !! By column
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: note  !! What is to be known of it

        type(results_t) :: results
        type(data_table_t) :: table
        type(string_t), allocatable :: names(:)
        integer :: i

        names = split(columns, ',')
        do i = 1, size(names)
            call table%column(names(i)%text, 'es16.8', names(i)%text)
        end do
        call table%add(values)
        call console%table(table)
        if (present(note)) call console%paragraph(note)
        call results%open(command)
        if (present(note)) call results%member('note', note)
        call results%publish(table, console, error)
    end subroutine publish_row
end module gracecg_cli_results
