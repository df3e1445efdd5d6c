!> The report page: what the report states without a table or a figure.
module gracecg_cli_chapter_statements
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, ARCSECOND, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text
    use gracecg_studies_statements, only: statement_t, write_statements, HOLDS, HOLDS_IN_PART, VERDICT_WORDS
    use gracecg_cli_document, only: table_rows_t, head_cell, text_cell, number_cell, number_cells, VERDICT_MET, &
        VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_cli_report_book, only: report_book_t, book_file, add_claim, rms_cells, COMMAND
    use gracecg_cli_number_text, only: fixed_text
    implicit none
    private
    public :: add_statements_chapter, page_runs

    character(*), parameter :: FILE = 'statements.csv'
    character(*), parameter :: BY_THEORY = 'arc-length'     !! Arcs of up to 300 s: their runs would take the longest

contains

    !> Runs of a statement's Monte Carlo on the page; 0: theory alone.
    pure integer function page_runs(name, runs)
        character(*), intent(in) :: name        !! One of STATEMENT_NAMES
        integer, intent(in) :: runs             !! Of the other Monte Carlos of the page

        page_runs = merge(0, runs, name == BY_THEORY)
    end function page_runs

    !> Adds the chapter on the statements.
    subroutine add_statements_chapter(book, statements, error)
        type(report_book_t), intent(inout) :: book
        type(statement_t), intent(in) :: statements(:)      !! In the order of STATEMENT_NAMES
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        call write_statements(book_file(book, FILE), COMMAND, book%seed, statements, error)
        if (allocated(error)) return
        call book%page%chapter('statements', 'What the report states without table or figure')
        call book%page%paragraph('Some statements of the report stand in its text alone. Each is computed here, and its '// &
                                 'verdict follows from the covariance analysis under the true noise spectra, or from the '// &
                                 'bound. Monte Carlo ('//integer_text(book%runs)//' runs) stands beside it where runs are '// &
                                 'cheap; longer arcs are shown by theory alone. `gracecg statements NAME` gives each of '// &
                                 'them, longer arcs with runs, too.')
        do i = 1, size(statements)
            call add_statement(book, statements(i))
        end do
    end subroutine add_statements_chapter

    subroutine add_statement(book, statement)
        type(report_book_t), intent(inout) :: book
        type(statement_t), intent(in) :: statement

        type(table_rows_t) :: rows
        character(:), allocatable :: id, cells, caption
        character(20), allocatable :: heads(:)
        integer :: i, kind

        id = 'statement_'//trim(statement%name)
        call describe_table(statement, caption, heads)
        do i = 1, size(statement%rows)
            associate (row => statement%rows(i))
                cells = head_cell(trim(row%case_name))//text_cell(trim(row%setting))
                if (row%runs > 0) then
                    cells = cells//rms_cells(row%rms, row%predicted)
                else if (row%torque_ratio > 0) then
                    cells = cells//number_cell(fixed_text(row%torque_ratio, 1))//number_cells(row%predicted/MILLIMETRE, 5)// &
                            number_cell(condition_text(row%condition))
                else if (row%condition > 0) then
                    cells = cells//number_cell(condition_text(row%condition))
                else if (row%stars > 0) then
                    cells = cells//number_cell(fixed_text(row%stars, 1))//number_cells(row%camera_sigma/ARCSECOND, 3)
                else
                    cells = cells//number_cells(row%predicted/MILLIMETRE, 5)
                end if
                call rows%add(cells)
            end associate
        end do
        call book%page%heading('`'//trim(statement%name)//'`: '//trim(statement%place))
        call book%page%paragraph('The report: '//trim(statement%claim)//'. Here: '//trim(statement%method)//'.')
        call book%page%table(caption, heads, rows, id)
        kind = VERDICT_MISSED
        if (statement%verdict == HOLDS) kind = VERDICT_MET
        if (statement%verdict == HOLDS_IN_PART) kind = VERDICT_PARTLY
        call book%page%verdict(kind, trim(statement%found), trim(statement%details))
        call add_claim(book, section_of(statement%place), id, trim(statement%claim), trim(statement%found), kind, &
                       trim(VERDICT_WORDS(statement%verdict)))
    end subroutine add_statement

    !> What stands above a statement's table and its columns, by what its rows have.
    subroutine describe_table(statement, caption, heads)
        type(statement_t), intent(in) :: statement
        character(:), allocatable, intent(out) :: caption
        character(20), allocatable, intent(out) :: heads(:)

        character(:), allocatable :: name
        integer :: i

        name = 'Statement '//trim(statement%name)//': '
        associate (row => statement%rows(1))
            if (row%runs > 0) then
                heads = [character(20) :: 'case', 'setting', (AXES(i)//' here', AXES(i)//' theory', i=1, 3)]
                caption = name//'RMS errors of the CG offset, mm, '//integer_text(row%runs)//' runs and theory'
            else if (row%torque_ratio > 0) then
                heads = [character(20) :: 'case', 'setting', 'torque ratio', 'x', 'y', 'z', 'condition']
                caption = name//'RMS of the rods'' torque over the others'', bound of the CG offset in mm, and the '// &
                    'condition of its information'
            else if (row%condition > 0) then
                heads = [character(20) :: 'case', 'setting', 'condition']
                caption = name//'condition of the normal matrix'
            else if (row%stars > 0) then
                heads = [character(20) :: 'case', 'in use', 'stars in the field', 'sigma x', 'sigma y', 'sigma boresight']
                caption = name//'stars in the used head''s field, and sigma of its attitude, arcsec'
            else
                heads = [character(20) :: 'case', 'setting', 'x', 'y', 'z']
                caption = name//'errors of the CG offset by theory, mm'
            end if
        end associate
    end subroutine describe_table

    function condition_text(condition) result(text)
        real(dp), intent(in) :: condition
        character(:), allocatable :: text

        character(12) :: digits

        text = fixed_text(condition, 1)
        if (condition < 1e4_dp) return
        write (digits, '(es9.1)') condition
        text = trim(adjustl(digits))
    end function condition_text

    !> 'sections 4.1 and 7.1(1)' as the summary has it: 'Section 4.1'.
    function section_of(place) result(text)
        character(*), intent(in) :: place
        character(:), allocatable :: text

        integer :: first, length

        first = scan(place, '0123456789')
        length = scan(trim(place(first:))//' ', ' ') - 1
        text = 'Section '//place(first:first + length - 1)
    end function section_of
end module gracecg_cli_chapter_statements
