!> The content of a page as JSON: blocks, cells, figures, with what needs escaping.
module test_document
    use gracecg_base_kinds, only: dp
    use gracecg_files_json, only: json_quoted, read_json_text, read_json_numbers
    use gracecg_cli_document
    use gracecg_cli_panels
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_document

    character(1), parameter :: LF = achar(10)

contains

    subroutine collect_document(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('quoted', test_quoted), &
                    new_unittest('blocks', test_blocks), &
                    new_unittest('long', test_long), &
                    new_unittest('cells', test_cells), &
                    new_unittest('panels', test_panels)]
    end subroutine collect_document

    subroutine test_quoted(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, json_quoted('a "b" \c'//LF), '"a \"b\" \\c\u000a"')
        if (.not. allocated(error)) call check(error, json_quoted(''), '""')
    end subroutine test_quoted

    subroutine test_blocks(error)
        type(error_type), allocatable, intent(out) :: error
        type(document_t) :: page, more

        call check(error, page%blocks(), '[]')
        call page%chapter('one', 'First "one"')
        call page%verdict(VERDICT_PARTLY, 'Nearly.')
        call more%paragraph('a < b')
        call page%append(more)
        call page%files('"a.csv","b.csv",')
        if (.not. allocated(error)) call check(error, page%blocks(), '['//LF// &
            '{"block":"chapter","id":"one","title":"First \"one\""},'//LF// &
            '{"block":"verdict","kind":"partly","words":"Nearly.","rest":""},'//LF// &
            '{"block":"paragraph","text":"a < b"},'//LF//'{"block":"files","names":["a.csv","b.csv"]}'//LF//']')
    end subroutine test_blocks

    !> Beyond the first size of the buffer.
    subroutine test_long(error)
        type(error_type), allocatable, intent(out) :: error
        type(document_t) :: page
        character(:), allocatable :: json
        integer :: i

        do i = 1, 300
            call page%paragraph(repeat('x', 500))
        end do
        json = page%blocks()
        call check(error, len(json), 300*(500 + len('{"block":"paragraph","text":""},') + 1) + 2)
    end subroutine test_long

    subroutine test_cells(error)
        type(error_type), allocatable, intent(out) :: error
        type(document_t) :: page
        type(table_rows_t) :: rows

        call rows%add(head_cell('front-1', rows=3, anchor='here')//number_cells([0.5_dp, -1.0_dp], 2))
        call rows%add(judged_cell(VERDICT_MET, 'inside', ' 0.1')//text_cell('words', wraps=.true.)// &
                      verdict_cell(VERDICT_MISSED, 'differs'))
        call page%table('A table', [character(4) :: 'case', 'x', ''], rows, 'id')
        call check(error, page%blocks(), '['//LF//'{"block":"table","id":"id","caption":"A table","heads":["case","x",""],'// &
                   '"stacks":false,"rows":[[{"head":"front-1","rows":3,"anchor":"here"},{"number":"0.50"},{"number":"-1.00"}],'// &
                   '[{"kind":"met","word":"inside","number":"0.1"},{"text":"words","wraps":true},'// &
                   '{"kind":"missed","verdict":"differs"}]]}'//LF//']')
    end subroutine test_cells

    !> A figure, and a drawing by its name.
    subroutine test_panels(error)
        type(error_type), allocatable, intent(out) :: error
        type(document_t) :: page
        type(panel_t) :: panels(2)
        real(dp), allocatable :: values(:)
        character(:), allocatable :: json, text
        logical :: ok

        panels(1) = panel_t(title='d_x', curves=curve('a.csv', 'time_s', 'x_mm', 1, 1e3_dp)//level(0.5_dp, 5))
        panels(2) = panel_t(has_limits=.true., low=-1.0_dp, high=1.0_dp, least=-2.0_dp, greatest=3.0_dp, &
                            curves=values_curve([1.0_dp, 2.5_dp], 0, 'd'))
        json = panel_grid(grid_t(x_label='time, s', x_high=60.0_dp, x_step=20.0_dp), panels, [legend_item_t('x', 1)], &
                          [5.0_dp, 6.0_dp], 'case')
        call read_json_numbers(json, 'x', values, ok)
        call check(error, ok .and. size(values) == 2)
        if (allocated(error)) return
        call check(error, index(json, '"panels":[{"title":"d_x","curves":[{"file":"a.csv","x":"time_s","y":"x_mm","colour":1,'// &
                                '"factor":1000},{"level":0.5,"colour":5}]},{"title":"","printed":[-1,1],'// &
                                '"range":[-2,3],"curves":[{"values":[1,2.5],"colour":0,"marker":"d"}]}]}') > 0, json)
        if (allocated(error)) return
        call check(error, index(json, '"marks":[5,6],"mark_name":"case"') > 0, json)
        if (allocated(error)) return
        call page%figure('f', json, 'below', 'title', 'what')
        call page%figure('g', 'frames', 'below')
        json = page%blocks()
        call check(error, index(json, '{"block":"drawing","id":"g","caption":"below","name":"frames"}') > 0, json)
        if (allocated(error)) return
        call read_json_text(json(index(json, '{'):), 'title', text, ok)
        call check(error, ok .and. text == 'title', text)
    end subroutine test_panels
end module test_document
