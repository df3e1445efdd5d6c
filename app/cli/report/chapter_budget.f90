!> The report page: Tables 1.1 and 1.2, why the offset is calibrated.
module gracecg_cli_chapter_budget
    use gracecg_base_kinds, only: dp
    use gracecg_cli_document, only: table_rows_t, head_cell, number_cell, number_cells, VERDICT_MET, VERDICT_PARTLY
    use gracecg_studies_com_budget, only: com_budget_t, com_budget, is_stated
    use gracecg_cli_report_book, only: report_book_t, add_claim
    use gracecg_cli_number_text, only: fixed_text, pick_text
    implicit none
    private
    public :: add_budget_chapter

contains

    !> Adds the chapter on the budget of the centre of mass.
    subroutine add_budget_chapter(book)
        type(report_book_t), intent(inout) :: book

        call book%page%chapter('budget', 'Why the offset is calibrated: Tables 1.1 and 1.2')
        call book%page%paragraph('The accelerometer must sit in the centre of mass (COM). On the ground it can be '// &
                                 'placed there within some tenths of a millimetre; in flight the COM moves as gas is '// &
                                 'consumed. The report takes both budgets from a distortion analysis of the '// &
                                 'satellite; they are inputs, so only the last line can be checked: the root of the '// &
                                 'sum of the squares (RSS) of the effects.')
        call add_budget(book, '1.1', 'Table 1.1. Ground error of the COM, mm', '', 3, 0.005_dp)
        call add_budget(book, '1.2', 'Table 1.2. In-flight stability of the COM, mm', ' (in 6 months)', 4, 0.00006_dp)
    end subroutine add_budget_chapter

    subroutine add_budget(book, table, caption, period, decimals, tolerance)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: table, caption, period
        integer, intent(in) :: decimals
        real(dp), intent(in) :: tolerance           !! Half a unit of the last printed digit, mm

        type(com_budget_t) :: budget
        type(table_rows_t) :: rows
        character(:), allocatable :: cells, id
        integer :: i, axis

        budget = com_budget(table)
        do i = 1, size(budget%effect)
            cells = head_cell(trim(budget%effect(i)))
            do axis = 1, 3
                cells = cells//number_cell(pick_text(is_stated(budget%error(axis, i)), &
                                                     fixed_text(budget%error(axis, i), decimals), '-'))
            end do
            call rows%add(cells)
        end do
        call rows%add(head_cell('RSS as printed')//number_cells(budget%printed_rss, decimals))
        call rows%add(head_cell('RSS of the lines above')//number_cells(budget%rss, decimals))
        call rows%add(head_cell('requirement'//period)//number_cells(budget%requirement, decimals))
        id = 'table_'//table(1:1)//'_'//table(3:3)
        call book%page%table(caption, [character(6) :: 'effect', 'dx', 'dy', 'dz'], rows, id)
        if (all(abs(budget%printed_rss - budget%rss) <= tolerance)) then
            call book%page%verdict(VERDICT_MET, 'The printed RSS follows from the printed effects.')
            call add_claim(book, 'Table '//table, id, 'RSS of the errors of the COM', &
                           'the printed RSS follows from the printed effects', VERDICT_MET, 'agrees')
        else
            call book%page%verdict(VERDICT_PARTLY, 'A slip of the print.', 'The printed effects along x give '// &
                                   fixed_text(budget%rss(1), 2)//' mm, not '//fixed_text(budget%printed_rss(1), 2)// &
                                   ' mm; y and z agree.')
            call add_claim(book, 'Table '//table, id, 'RSS of the errors of the COM', 'x is printed '// &
                           fixed_text(budget%printed_rss(1), 2)//', its effects give '//fixed_text(budget%rss(1), 2)// &
                           '; y and z agree', VERDICT_PARTLY, 'agrees but for a slip')
        end if
    end subroutine add_budget
end module gracecg_cli_chapter_budget
