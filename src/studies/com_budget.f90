!> Tables 1.1 and 1.2 of CSR-TM-00-01: how far the centre of mass may lie from its place, on the ground
!> and in flight, which is why the offset is calibrated.
module gracecg_studies_com_budget
    use gracecg_base_kinds, only: dp
    use gracecg_files_data_table, only: data_table_t
    use gracecg_studies_table_com_budget, only: BUDGET_TABLE, BUDGET_EFFECT, BUDGET_X, BUDGET_Y, BUDGET_Z
    implicit none
    private
    public :: com_budget_table, rss_of_effects

contains

    !> Both tables as printed, each effect, their root of the sum of squares ('rss') and the requirement; and behind
    !> each 'rss' that of the printed effects. What is printed "---" stays empty.
    function com_budget_table() result(table)
        type(data_table_t) :: table

        integer :: i

        call table%columns_of('table,effect,dx_mm,dy_mm,dz_mm')
        do i = 1, size(BUDGET_TABLE)
            call add_row(BUDGET_EFFECT(i), [BUDGET_X(i), BUDGET_Y(i), BUDGET_Z(i)])
            if (BUDGET_EFFECT(i) == 'rss') call add_row('rss of the effects', rss_of_effects(BUDGET_TABLE(i)))
        end do

    contains

        subroutine add_row(effect, values)
            character(*), intent(in) :: effect
            real(dp), intent(in) :: values(3)       ! mm; negative: not stated

            integer :: axis

            call table%add(BUDGET_TABLE(i))
            call table%add(effect)
            do axis = 1, 3
                if (values(axis) >= 0) then
                    call table%add(values(axis))
                else
                    call table%add_nothing()
                end if
            end do
        end subroutine add_row
    end function com_budget_table

    !> Root of the sum of the squares of a table's effects along x, y, z, mm.
    pure function rss_of_effects(table) result(rss)
        character(*), intent(in) :: table           !! '1.1' or '1.2'
        real(dp) :: rss(3)

        logical :: effects(size(BUDGET_TABLE))

        effects = BUDGET_TABLE == table .and. BUDGET_EFFECT /= 'rss' .and. BUDGET_EFFECT /= 'requirement'
        rss = sqrt([sum(BUDGET_X**2, effects .and. BUDGET_X >= 0), sum(BUDGET_Y**2, effects .and. BUDGET_Y >= 0), &
                    sum(BUDGET_Z**2, effects .and. BUDGET_Z >= 0)])
    end function rss_of_effects
end module gracecg_studies_com_budget
