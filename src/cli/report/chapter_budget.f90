!> The report page: Tables 1.1 and 1.2, why the offset is calibrated.
module gracecg_cli_chapter_budget
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_cli_html, only: VERDICT_MET, VERDICT_PARTLY
    use gracecg_studies_com_budget, only: com_budget_t, com_budget, is_stated
    use gracecg_cli_book, only: report_book_t, add_finding
    use gracecg_cli_number_text, only: fixed_text
    implicit none
    private
    public :: add_budget_chapter

contains

    !> Adds the chapter on the budget of the centre of mass.
    subroutine add_budget_chapter(book)
        type(report_book_t), intent(inout) :: book

        call book%page%chapter('budget', 'Why the offset is calibrated: Tables 1.1 and 1.2')
        call book%page%paragraph('The accelerometer must sit in the centre of mass (COM). On the ground '// &
                                 'it can be placed there within some tenths of a millimetre; in flight '// &
                                 'the COM moves as gas is consumed. The report takes both budgets from '// &
                                 'a distortion analysis of the satellite; they are inputs, so only the '// &
                                 'last line can be checked: the root of the sum of the squares (RSS) of '// &
                                 'the effects.')
        call add_budget(book, '1.1', 'Table 1.1. Ground error of the COM, mm', '', 3, 0.005_dp)
        call add_budget(book, '1.2', 'Table 1.2. In-flight stability of the COM, mm', ' (in 6 '// &
                        'months)', 4, 0.00006_dp)
    end subroutine add_budget_chapter

    subroutine add_budget(book, table, caption, period, decimals, tolerance)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: table, caption, period
        integer, intent(in) :: decimals
        real(dp), intent(in) :: tolerance           !! Half a unit of the last printed digit, mm

        type(com_budget_t) :: budget
        logical :: same(3)
        integer :: i, axis

        budget = com_budget(table)
        same = abs(budget%printed_rss - budget%rss) <= tolerance
        associate (page => book%page)
            call page%begin_table(caption, 'table_'//table(1:1)//'_'//table(3:3))
            call page%begin_row()
            call page%column_head('effect')
            do axis = 1, 3
                call page%column_head('d'//AXES(axis), numeric=.true.)
            end do
            call page%end_row()
            call page%head_end()
            do i = 1, size(budget%effect)
                call page%begin_row()
                call page%row_head(trim(budget%effect(i)))
                do axis = 1, 3
                    if (is_stated(budget%error(axis, i))) then
                        call page%number_cell(fixed_text(budget%error(axis, i), decimals))
                    else
                        call page%number_cell('-')
                    end if
                end do
                call page%end_row()
            end do
            call add_row(book, 'RSS as printed', budget%printed_rss, decimals)
            call add_row(book, 'RSS of the lines above', budget%rss, decimals)
            call add_row(book, 'requirement'//period, budget%requirement, decimals)
            call page%end_table()
        end associate
        if (all(same)) then
            call book%page%verdict(VERDICT_MET, 'The printed RSS follows from the printed effects.')
            call add_finding(book, 'Table '//table, 'table_'//table(1:1)//'_'//table(3:3), &
                           'RSS of the errors of the COM', 'the printed RSS follows from the printed '// &
                           'effects', &
                           VERDICT_MET, 'agrees')
        else
            call book%page%verdict(VERDICT_PARTLY, 'A slip of the print.', 'The printed effects along x '// &
                                   'give '// &
                                   fixed_text(budget%rss(1), 2)//' mm, not '// &
                                   fixed_text(budget%printed_rss(1), 2)//' mm; y and z agree.')
            call add_finding(book, 'Table '//table, 'table_'//table(1:1)//'_'//table(3:3), &
                           'RSS of the errors of the COM', 'x is printed '// &
                           fixed_text(budget%printed_rss(1), 2)// &
                           ', its effects give '//fixed_text(budget%rss(1), 2)//'; y and z agree', &
                           VERDICT_PARTLY, 'agrees but for a slip')
        end if
    end subroutine add_budget

    subroutine add_row(book, label, values, decimals)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: label
        real(dp), intent(in) :: values(3)           !! mm
        integer, intent(in) :: decimals

        integer :: axis

        call book%page%begin_row()
        call book%page%row_head(label)
        do axis = 1, 3
            call book%page%number_cell(fixed_text(values(axis), decimals))
        end do
        call book%page%end_row()
    end subroutine add_row
end module gracecg_cli_chapter_budget
