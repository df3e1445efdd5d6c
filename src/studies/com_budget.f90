!> Tables 1.1 and 1.2 of CSR-TM-00-01: how far the centre of mass may lie from its place, on the ground
!> and in flight, which is why the offset is calibrated.
module gracecg_studies_com_budget
    use gracecg_base_kinds, only: dp
    use gracecg_studies_table_com_budget, only: BUDGET_TABLE, BUDGET_EFFECT, BUDGET_X, BUDGET_Y, BUDGET_Z
    implicit none
    private
    public :: com_budget_t, com_budget, is_stated

    character(*), parameter :: RSS = 'rss', REQUIREMENT = 'requirement'      !! The last rows of a table

    !> One of the tables, mm.
    type :: com_budget_t
        character(len(BUDGET_EFFECT)), allocatable :: effect(:)    !! Names of the effects
        real(dp), allocatable :: error(:, :)        !! (axis, effect); see is_stated
        real(dp) :: printed_rss(3) = 0              !! As the report has it
        real(dp) :: requirement(3) = 0    !! Along x, y, z
        real(dp) :: rss(3) = 0                      !! Root of the sum of the squares of the effects
    end type com_budget_t

contains

    !> The table of a number; without an effect when there is none of that number.
    pure function com_budget(table) result(budget)
        character(*), intent(in) :: table           !! '1.1' or '1.2'
        type(com_budget_t) :: budget

        logical :: in_table(size(BUDGET_TABLE))
        real(dp) :: values(3)
        integer :: i, n

        in_table = BUDGET_TABLE == table
        n = count(in_table .and. BUDGET_EFFECT /= RSS .and. BUDGET_EFFECT /= REQUIREMENT)
        allocate (budget%effect(n), budget%error(3, n))
        n = 0
        do i = 1, size(BUDGET_TABLE)
            if (.not. in_table(i)) cycle
            values = [BUDGET_X(i), BUDGET_Y(i), BUDGET_Z(i)]
            select case (BUDGET_EFFECT(i))
            case (RSS)
                budget%printed_rss = values
            case (REQUIREMENT)
                budget%requirement = values
            case default
                n = n + 1
                budget%effect(n) = BUDGET_EFFECT(i)
                budget%error(:, n) = values
            end select
        end do
        budget%rss = sqrt(sum(merge(budget%error, 0.0_dp, is_stated(budget%error))**2, 2))
    end function com_budget

    !> Whether the report states an error there; else it prints "---".
    elemental logical function is_stated(error)
        real(dp), intent(in) :: error       !! mm

        is_stated = error >= 0
    end function is_stated
end module gracecg_studies_com_budget
